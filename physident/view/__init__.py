"""Pictures of recordings, models and diagnoses; ``physident.view(...)``, the call, shows a session.

The package and the public function have one name: the package can be called, see ``session.view``.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any


class _Callable(ModuleType):
    def __call__(self, *args: Any, **options: Any) -> None:
        from physident.view.session.session import view

        view(*args, **options)


sys.modules[__name__].__class__ = _Callable
view = sys.modules[__name__]  # what the package's table of public names finds
