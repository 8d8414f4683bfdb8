"""The form of every verb: options that take several files, --force, and its page of --help."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from difflib import get_close_matches
from functools import wraps
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

from physident.cli.replacement import replacing_any
from physident.outputs import is_standard_output

if TYPE_CHECKING:
    from physident.effects.effect import Effect

FORCE = "--force"
FORCED = "physident.forced"  # key of a context's notes
WITH_EFFECTS = {"model", "effects", "diagnosis"}  # parameters of verbs that take effects


class Verb(TyperCommand):
    """A verb of the command line.

    An option that means several files takes all words up to the next option, as a shell's pattern gives them. A result on
    standard output stands alone there: what else the verb prints goes to standard error.
    """

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        plain = args[: args.index("--")] if "--" in args else args
        ctx.meta[FORCED] = FORCE in plain
        several = {name for option in self.params if _takes_files(option) for name in option.opts}
        words = [word for word in plain if word != FORCE]
        try:
            return super().parse_args(ctx, [*repeated(words, several), *args[len(plain) :]])
        except Exception as error:
            if option := getattr(error, "option_name", ""):
                _suggest(error, option, [name for one in self.params for name in one.opts])
            raise

    def invoke(self, ctx: Any) -> Any:
        import sys

        results = [value for value in ctx.params.values() if value is not None and is_standard_output(str(value))]
        with replacing_any(ctx.meta[FORCED]), redirect_stdout(sys.stderr if results else sys.stdout):
            return super().invoke(ctx)

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        return [
            re.sub(r"[{\[]+(\w+)[^\w]*", r"\1...", p) if "..." in p else p.strip("{}")
            for p in super().collect_usage_pieces(ctx)
        ]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        arguments, options = [], []
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is None:
                continue
            if parameter.param_type_name == "argument":
                arguments.append((str(parameter.metavar), record[1]))
            else:
                options.append(record)
        options.insert(-1, (FORCE, "Replace existing files that physident did not write."))
        for heading, rows in (("Arguments", arguments), ("Options", options)):
            if rows:
                with formatter.section(heading):
                    formatter.write_dl(rows)


def _bring(ctx: typer.Context, files: list[str] | None) -> list[str] | None:
    """Bring effects of the user's own into the catalogue, for one run of a verb."""
    if not files or ctx.resilient_parsing:
        return files
    from physident.effects.catalogue import CATALOGUE, load_effects

    before = dict(CATALOGUE)

    def restore() -> None:
        CATALOGUE.clear()
        CATALOGUE.update(before)

    ctx.call_on_close(restore)
    for file in files:
        for effect in load_effects(file):
            _warn_if_broken(effect, file)
    return files


def _warn_if_broken(effect: type[Effect], file: str) -> None:
    """Warn of an effect that breaks the contract of all effects: its results would be wrong without a word."""
    from physident.errors import warn
    from physident.testing import check_effect

    try:
        check_effect(effect)
    except AssertionError as error:
        first, *more = str(error).splitlines()
        rest = f", and {len(more)} more" if more else ""
        warn(f"{file}: {first}{rest}; physident.testing.check_effect checks this, and results with it may be wrong")


EffectsFromOption = Annotated[
    list[str] | None,
    typer.Option(
        "--effects-from",
        metavar="FILE...",
        is_eager=True,
        callback=_bring,
        help="Python files that define effects of your own, up to the next option.",
    ),
]


def with_effects_from(function: Callable[..., Any]) -> Callable[..., Any]:
    """A verb with the option --effects-from, where it takes effects by name, a model or a diagnosis."""
    signature = inspect.signature(function, eval_str=True)
    if not WITH_EFFECTS & set(signature.parameters):
        return function

    @wraps(function)
    def verb(*args: Any, effects_from: list[str] | None = None, **options: Any) -> Any:
        return function(*args, **options)

    option = inspect.Parameter(
        "effects_from", inspect.Parameter.KEYWORD_ONLY, default=None, annotation=EffectsFromOption
    )
    verb.__signature__ = signature.replace(parameters=[*signature.parameters.values(), option])  # pyright: ignore[reportAttributeAccessIssue]
    verb.__annotations__ = {**function.__annotations__, "effects_from": EffectsFromOption}
    return verb


class Application(typer.Typer):
    """A typer application whose commands are verbs."""

    def command(self, name: str | None = None, **settings: Any) -> Any:
        register = super().command(name, **{"cls": Verb, **settings})
        return lambda function: register(with_effects_from(function))


def _takes_files(option: Any) -> bool:
    """Whether an option means several files: one with several values whose name does not end in "..." is
    repeated, as --lock, and as --model where recordings may follow it."""
    return getattr(option, "multiple", False) and str(getattr(option, "metavar", "")).endswith("...")


def repeated(words: Sequence[str], several: set[str]) -> list[str]:
    """The words with each option that takes ``several`` values repeated before every one of them."""
    result: list[str] = []
    option, fresh = "", False  # the option that the next word belongs to; whether it has no value yet
    for word in words:
        name, has_value, value = word.partition("=")
        if name in several:
            option, fresh = name, not has_value
            result += [name, value] if has_value else []
        elif word.startswith("-") and word != "-" and not fresh:
            option = ""
            result.append(word)
        elif option:
            result += [option, word]
            fresh = False
        else:
            result.append(word)
    return [*result, option] if fresh else result


def _suggest(error: Any, option: str, known: list[str]) -> None:
    """Add the nearest option to the message for one that does not exist."""
    near = get_close_matches(option, known, n=1)
    if "No such option" in str(getattr(error, "message", "")):
        error.message = f"there is no option {option}" + (f", did you mean {near[0]}" if near else "")
        error.possibilities = None
