"""What a diagnosis leaves of the residual, in sentences."""

from __future__ import annotations

from collections.abc import Sequence

from physident.diagnosis.remainder.unexplained import Unexplained
from physident.diagnosis.result.findings import Finding, Verdict
from physident.diagnosis.result.wording import listed, numbered, parts_of

AS_LARGE = "as large as on the model's own recordings"
UNKNOWN = 100.0  # times: a model that errs by so much along a recording that it was not fitted to does not know its motion at all
USUAL = "no larger than is usual for this model"


def remainder_sentence(
    verdict: Verdict,
    findings: Sequence[Finding],
    old: bool,
    compared: bool,
    as_own: bool = False,
    large: Sequence[Unexplained] = (),
) -> str:
    """What is left beside the ``findings``: of a comparison with motions from before, where all recordings are ``compared``, and beside what
    the model always lacked, where an ``old`` finding was told apart; ``as_own``, it remembers, but is as large as on the model's own recordings,
    or on some joints as ``large`` as is only usual."""
    rest = "What is left of the comparison with motions from before" if compared else "The remaining residual"
    if verdict == "partly_explained":
        if large:
            return f"{rest} is {USUAL}, but on {_joints(large)} it is {_times_own(large)}."
        return "Some structure in the residual matches no effect of the catalogue."
    if verdict == "unexplained":
        what = "What is left beside it" if parts_of(findings) else "The residual"
        return f"{what} has structure that no effect of the catalogue predicts on unseen data."
    noise = USUAL if large else AS_LARGE if as_own else "noise"
    if verdict == "explained" or parts_of(findings):
        return f"{rest} is {noise}."
    if old:
        return f"No change beats chance, and beside what the model lacked before the residual is {noise}."
    return f"No {'change' if compared else 'effect of the catalogue'} beats chance, and {rest[0].lower()}{rest[1:]} is {noise}."


def grown_sentence(grown: Sequence[Unexplained]) -> str:
    """Which joints err by how much more than on the model's own recordings; empty where none does."""
    if not grown:
        return ""
    words = grown_in_words(grown)
    return f"{words[0].upper()}{words[1:]}, and nothing that was found describes it."


def no_structure_words(as_own: Sequence[Unexplained], large: Sequence[Unexplained]) -> str:
    """Why a residual says nothing more: it is noise, or, on some joints, ``as_own``, as large as on the model's own recordings, or as ``large`` as
    is only usual."""
    if not as_own:
        return "noise; the residual has no more memory than filtered noise, or lies within the noise floor"
    return f"no more than {'is usual' if large else 'before'}; on {_joints(as_own)} it is {_times_own(as_own)}"


def hidden_sentence(left: Sequence[Unexplained]) -> str:
    """That a change may hide in what is left of some joints, and what would show it."""
    return (
        f"On {_joints(left)} a change may hide in it, because the model errs so differently on its own recordings: repeat a motion of theirs, or"
        " identify from more of them."
    )


def mostly_left_sentence(joints: Sequence[int]) -> str:
    """On which joints (from 1) the causes are not what is mostly wrong."""
    return f"What was found is not most of the error of joint{'s' if len(joints) > 1 else ''} {numbered(joints)}."


def as_before_sentence(left: Sequence[Unexplained]) -> str:
    """How large what is left is beside what a model leaves on its own recordings."""
    return f"It is {_times_own(left)}."


def _times_own(left: Sequence[Unexplained]) -> str:
    """How many times what the model leaves on its own recordings, and what is usual."""
    usual = [one.usual_times for one in left if one.usual_times is not None]
    most = f", and up to {max(usual):.1f} times is usual" if usual else ""
    if usual and max(usual) > UNKNOWN:
        most = "; how much is usual these do not tell, for each of them shows what the others do not"
    low, high = (f"{one(x.times_own or 0.0 for x in left):.1f}" for one in (min, max))
    return f"{low if low == high else f'{low} to {high}'} times what the model leaves on its own recordings{most}"


def grown_in_words(grown: Sequence[Unexplained]) -> str:
    """Joints and by how many times they err more than on the model's own recordings."""
    texts = [f"joint {one.joint} errs {one.errs_times:.2g} times" for one in grown]
    return f"{listed(texts)} as much as on the model's own recordings"


def times_own_in_brackets(left: Unexplained) -> str:
    """How many times as large as before a residual is, in brackets; empty where that is not asked."""
    return f" ({left.times_own:.2g} times that of the model's own recordings)" if left.times_own else ""


def _joints(left: Sequence[Unexplained]) -> str:
    return f"joint{'s' if len(left) > 1 else ''} {numbered([one.joint for one in left])}"
