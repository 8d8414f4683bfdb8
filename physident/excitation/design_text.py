"""A design in words: what it reaches, how near its limits are, and a verdict."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from physident.excitation.design import Design
    from physident.excitation.discriminate import Detectable, Discrimination

UNSCALED = "unscaled"
BANDS = ((20.0, "good"), (100.0, "usable"))


def design_text(design: Design) -> str:
    """The text of ``Design.__repr__``."""
    t = design.trajectory
    periods = t.duration * t.base_frequency
    rows = [
        f"Design: {t.n} joints, {t.harmonics} harmonics of {t.base_frequency:g} Hz, {periods:g} period{'s' if periods > 1 else ''} of {1 / t.base_frequency:.4g} s",
        f"  condition number {design.condition:.2f} ({design.columns} columns, {design.weighting}); criterion {design.criterion}",
        f"  found in {design.seconds:.1f} s ({design.processor_seconds:.1f} s of processor time), seed {design.seed},"
        f" {len(design.starts)} starts ended within the limits",
        "  limit            nearest on            reached     allowed      margin",
    ]
    for limit in dict.fromkeys(one.limit for one in design.margins):
        own = [one for one in design.margins if one.limit == limit]
        worst = min(own, key=lambda one: one.margin / max(abs(one.allowed), 1e-9))
        decided = [one.where.removeprefix("joint ") for one in own if one.active]
        note = f"  active: {', '.join(decided)}" if decided else ""
        rows.append(
            f"  {limit:<16} {worst.where:<18} {worst.reached:10.4g} {worst.allowed:11.4g} {worst.margin:11.3g} {worst.unit:<8}{note}"
        )
    if design.excluded:
        far = [text for text in design.excluded if not text.endswith("joined")]
        rows.append(f"  links not kept apart: neighbours{'; ' if far else ''}{'; '.join(far)}")
    rows.append(f"  {design.manipulability!r}")
    band = next((name for limit, name in BANDS if design.condition <= limit), "poor")
    known = (
        f"{band}; " if design.weighting == UNSCALED else ""
    )  # of scaled columns a condition number has no usual size
    rows.append(f"verdict: {known}{_kept(design)}")
    return "\n".join(rows)


def discrimination_text(found: Discrimination) -> str:
    """The text of ``Discrimination.__repr__``."""
    text = design_text(found.design).splitlines()
    rows = [
        f"Tells {found.a} from {found.b}: least magnitude that shows beside the rival, worst over its shapes;"
        f" the model is {'held' if found.held else 'refitted'}",
        "  joint  effect                        magnitude  unit          random motions need",
    ]
    worst: dict[tuple[int, str], Detectable] = {}
    for one in found.detectable:
        key = (one.joint, one.effect)
        # an effect of several parameters shows as soon as one of them does, a shape is not ours to choose
        shapes = [d for d in found.detectable if (d.joint, d.effect, d.shape) == (*key, one.shape)]
        best = min(shapes, key=lambda d: d.magnitude)
        if key not in worst or best.magnitude > worst[key].magnitude:
            worst[key] = best
    for one in worst.values():
        never = one.magnitude == float("inf")
        size = "     never" if never else f"{one.magnitude:10.3g}"
        usual = "never" if one.usual == float("inf") else f"{one.usual:.3g}"
        more = "" if never or one.usual == float("inf") else f"  ({one.usual / one.magnitude:.1f} times)"
        rows.append(f"  {one.joint:5d}  {one.effect:<28} {size}  {one.unit:<12}  {usual}{more}")
    hidden = sorted({one.joint for one in worst.values() if one.magnitude == float("inf")})
    note = f"; no motion shows it on joint {', '.join(map(str, hidden))}" if hidden else ""
    return "\n".join([*text[:-1], *rows, f"verdict: {_kept(found.design)}{note}"])


def _kept(design: Design) -> str:
    """Which limits hold: those that were checked."""
    if design.limits == "joint":
        return "the joints' limits hold, starts and ends at rest; torque, tool, table and links were not checked"
    return "every limit holds, starts and ends at rest"
