"""Classes of effects from outside of the package: checked, and added to a catalogue."""

from __future__ import annotations

import importlib.util
import inspect
import sys
from collections.abc import Iterable
from importlib.metadata import EntryPoint
from pathlib import Path
from types import ModuleType
from typing import Any

from physident.effects.classification import Family
from physident.effects.effect import Effect
from physident.effects.user.formula import FormulaEffect
from physident.effects.user.guarded import guard, line_of
from physident.errors import InputError

GROUP = "physident.effects"  # of the entry points that packages declare effects in


def add_effect(catalogue: dict[str, Any], effect: Any, origin: str, sha256: str = "") -> None:
    """Add a class of effects to a catalogue; ``origin`` says where it comes from, and ``sha256`` is the hash of that file.

    Raises InputError for a class that is not complete, and for a name that another effect has already.
    """
    check_class(catalogue, effect, origin)
    effect.origin, effect.origin_sha256 = origin, sha256
    guard(effect)
    catalogue[effect.name] = effect


def check_class(catalogue: dict[str, Any], effect: Any, origin: str) -> None:
    """Raises InputError for what cannot be added to a catalogue, as in ``add_effect``."""
    where = f"{origin}: {getattr(effect, '__name__', effect)}"
    if not (inspect.isclass(effect) and issubclass(effect, Effect)):
        raise InputError(f"{where} is no effect; expected a subclass of physident.Effect")
    name = getattr(effect, "name", None)
    if not isinstance(name, str) or not name.isidentifier():
        raise InputError(f"{where} has the name {name!r}; expected a word such as name = 'lubricant_friction'")
    for field, kind in (("unit", str), ("family", Family)):
        if not isinstance(getattr(effect, field, None), kind):
            raise InputError(f"{where} states no {field}; expected {field} = {_EXAMPLE[field]}")
    if missing := sorted(effect.__abstractmethods__):
        raise InputError(f"{where} lacks {', '.join(missing)}; expected every method of its base class")
    if issubclass(effect, FormulaEffect) and not effect.formulas:
        raise InputError(f"{where} states no formulas; expected formulas = ('v**3',), or other NumPy of q, v and a")
    settings = vars(effect).get(
        "__dataclass_params__"
    )  # of the class itself: fields of its own would not be found else
    if settings is None or not settings.frozen:
        raise InputError(f"{where} is no frozen dataclass; expected @dataclass(frozen=True) above it")
    known = catalogue.get(name)
    if known not in (None, effect) and known.origin != origin:
        whose = f"from {known.origin}" if known.origin else "of the catalogue"
        raise InputError(f"{where} has the name {name!r}, as the effect {whose}; expected a name of its own")


_EXAMPLE = {"unit": "'N m'", "family": "Family.FRICTION, or another of physident.Family"}


def effects_in_file(path: str | Path) -> list[type[Effect]]:
    """The classes of effects that a Python file defines; raises InputError, naming file and line, where it fails or has none."""
    file = Path(path)
    if not file.is_file():
        raise InputError(f"{path}: not found; expected a Python file that defines effects")
    if file.suffix != ".py":
        raise InputError(f"{path}: not a Python file; expected one that ends in .py and defines effects")
    name = f"physident_effects_{file.stem}"
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up
    try:
        # not by the loader, whose bytecode on disk is taken for that of a file edited within the same second
        exec(compile(file.read_bytes(), str(file), "exec", dont_inherit=True), vars(module))
    except KeyboardInterrupt:
        raise
    except InputError as error:  # a class says what is wrong with it, its file is not known to it
        raise InputError(f"{path}: {line_of(error, file)}{error}") from None
    except BaseException as error:
        raise InputError(
            f"{path}: {line_of(error, file)}{type(error).__name__}: {error}; expected Python that defines effects"
        ) from None
    found = effects_in_module(module)
    if not found:
        raise InputError(f"{path}: defines no effect; expected a subclass of physident.Effect")
    names = [getattr(one, "name", None) for one in found]
    for one, name in zip(found, names, strict=True):
        if name is not None and names.count(name) > 1:
            raise InputError(
                f"{path}: {one.__name__} has the name {name!r}, as another effect there; expected a name of its own"
            )
    return found


def effects_in_module(module: ModuleType) -> list[type[Effect]]:
    """The classes of effects that a module itself defines, but for those that are a base of another and have no name."""
    classes = [value for value in vars(module).values() if inspect.isclass(value) and issubclass(value, Effect)]
    own = dict.fromkeys(one for one in classes if one.__module__ == module.__name__)
    return [one for one in own if "name" in vars(one) or not any(one in other.__bases__ for other in own)]


def add_entry_points(catalogue: dict[str, Any], entry_points: Iterable[EntryPoint]) -> None:
    """Add the effects of installed packages: each entry point names a class, or a module of classes.

    Raises InputError, naming the package, for one that cannot be loaded.
    """
    for entry in entry_points:
        package = entry.dist.name if entry.dist is not None else entry.value
        try:
            loaded = entry.load()
        except Exception as error:
            raise InputError(
                f"package {package}: its entry point {entry.value!r} ({GROUP}) cannot be loaded: {type(error).__name__}: {error};"
                " correct or remove that package"
            ) from None
        for effect in effects_in_module(loaded) if isinstance(loaded, ModuleType) else [loaded]:
            add_effect(catalogue, effect, f"package {package}")
