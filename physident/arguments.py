"""Arguments of the wrong kind are refused in one line, before anything is computed.

Only calls from outside are checked (``physident.identify``): modules of the package import one another's functions directly.
"""

from __future__ import annotations

import inspect
import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from pathlib import Path
from typing import Any, ForwardRef, Literal, ParamSpec, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from physident.errors import InputError

P = ParamSpec("P")
T = TypeVar("T")
LARGEST_SEED = 2**64  # beyond, a seed is a mistake
LONGEST = 40  # characters of a value in a message
WORDS: dict[Any, tuple[str, str]] = {
    str: ("text", "texts"),
    Path: ("a path", "paths"),
    int: ("a whole number", "whole numbers"),
    float: ("a number", "numbers"),
    bool: ("True or False", "booleans"),
    type(None): ("None", "None"),
}


def checked(function: Callable[P, T]) -> Callable[P, T]:
    """The function with its arguments held against its annotations; raises InputError for one that does not fit, for a
    missing one and for an unknown name."""
    signature, name = inspect.signature(function), function.__name__
    hints: dict[str, Any] = {}

    @wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> T:
        try:
            given = signature.bind(*args, **kwargs).arguments
        except TypeError as error:
            raise InputError(f"{name}: {error}; expected {name}({', '.join(signature.parameters)})") from None
        if not hints:
            hints.update(get_type_hints(function))
        for parameter, value in given.items():
            if signature.parameters[parameter].kind is inspect.Parameter.VAR_KEYWORD:
                continue
            if not _fits(value, hints[parameter]):
                raise InputError(f"{name}: {parameter} is {came(value)}, expected {expected(hints[parameter])}")
            if parameter == "seed" and not 0 <= value < LARGEST_SEED:  # pyright: ignore[reportOperatorIssue]
                raise InputError(f"{name}: seed is {came(value)}, expected a whole number from 0 to 2^64")
        return function(*args, **kwargs)

    return call


def came(value: object) -> str:
    """A value in a few words: "a Robot", "a list of Recording", "'wls'"."""
    if value is None or isinstance(value, str | int | float):
        text = repr(value)
        return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
    name = type(value).__name__
    if isinstance(value, list | tuple):
        return f"a {name} of {type(value[0]).__name__}" if value else f"an empty {name}"
    return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"


def expected(hint: Any, several: bool = False) -> str:
    """A type in words: "a Robot, text or a path"."""
    origin, inside = get_origin(hint), get_args(hint)
    kind = origin if isinstance(origin, type) else hint
    if origin in (Union, types.UnionType):
        words = list(dict.fromkeys(expected(one, several) for one in inside))
        return " or ".join(filter(None, (", ".join(words[:-1]), words[-1])))
    if origin is Literal:
        return " or ".join(map(repr, inside))
    if hint in WORDS:
        return WORDS[hint][several]
    if kind is np.ndarray:
        return "arrays" if several else "an array"
    if isinstance(kind, type) and issubclass(kind, Mapping):
        return f"{'mappings' if several else 'a mapping'} from {expected(inside[0])} to {expected(inside[1])}"
    if isinstance(kind, type) and inside and issubclass(kind, Iterable):
        return f"{'lists' if several else 'a list'} of {expected(inside[0], several=True)}"
    if isinstance(hint, ForwardRef):
        return "them"
    if origin is not None:
        return "functions" if several else "a function"
    name = str(getattr(hint, "__name__", hint))
    return f"{name}s" if several else f"{'an' if name[0] in 'AEIOU' else 'a'} {name}"


def _fits(value: object, hint: Any) -> bool:
    from typeguard import CollectionCheckStrategy, ForwardRefPolicy, TypeCheckError, check_type

    union = get_origin(hint) in (Union, types.UnionType)
    kinds = get_args(hint) if union else (hint,)
    if isinstance(value, str):  # a text is no list of texts
        kinds = [kind for kind in kinds if not _is_list(kind)]
    if not any(get_origin(kind) is np.ndarray for kind in kinds):
        value = _plain(value)
    if isinstance(value, list | tuple):  # of what can be walked through once only, the items are not looked at
        kinds = [Sequence[get_args(kind)[0]] if _is_list(kind) else kind for kind in kinds]
    if not kinds:
        return False
    try:
        check_type(
            value,
            Union[tuple(kinds)],  # noqa: UP007
            forward_ref_policy=ForwardRefPolicy.IGNORE,
            collection_check_strategy=CollectionCheckStrategy.ALL_ITEMS,
        )
    except TypeCheckError:
        return False
    return True


def _is_list(hint: Any) -> bool:
    """Whether a type is that of a list of anything; arrays and mappings are not."""
    origin = get_origin(hint)
    return isinstance(origin, type) and issubclass(origin, Iterable) and not issubclass(origin, np.ndarray | Mapping)


def _plain(value: object) -> object:
    """Numbers and lists of Python in place of those of NumPy, which are as good."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, list | tuple):
        return type(value)(map(_plain, value)) if type(value) in (list, tuple) else value
    return value


def refuse_one_number(owner: str, **given: Any) -> None:
    """Raises InputError, naming the ``owner``, for a value that is one number where several are expected in a row, or an empty row; None is
    no value."""
    for name, value in given.items():
        if value is not None and not hasattr(value, "__len__"):
            raise InputError(f"{owner}: {name} is {value!r}, expected numbers in a row, such as ({value!r},)")
        if value is not None and not len(value):
            raise InputError(
                f"{owner}: {name} is {value!r}, expected one number or more; leave {name} out for the default"
            )
