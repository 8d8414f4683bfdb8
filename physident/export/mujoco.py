"""MuJoCo as a module; it is an extra of this package."""

from __future__ import annotations

from typing import Any

from physident.errors import InputError


def mujoco_module() -> Any:
    """The module ``mujoco``; raises InputError where it is not installed."""
    try:
        import mujoco
    except ImportError as error:
        raise InputError(f"MuJoCo is not there ({error}); install it with: pip install 'physident[mujoco]'") from None
    return mujoco
