"""A motion that separates two rival effects, and how large the effects have to be to show."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from physident.excitation.design import Design
from physident.excitation.detectability import Detectable


@dataclass(frozen=True, eq=False, kw_only=True)
class Discrimination:
    """A ``design`` that separates effects ``a`` and ``b``, and the magnitudes that become ``detectable``.

    The torque noise has an RMS of ``noise`` (n,) [N m|N], and ``worth`` (n,) [1/s] independent samples per second. The model
    is refitted beside the two effects, or fixed (``model_fixed``) where it would otherwise contain one of them.
    """

    a: str
    b: str
    model_fixed: bool
    design: Design
    detectable: tuple[Detectable, ...]
    noise: tuple[float, ...]
    worth: tuple[float, ...]

    def as_dict(self) -> dict[str, Any]:
        """The design and the detectable magnitudes, for JSON (schema physident.design/1); never is null."""
        return {
            **self.design.as_dict(),
            "effects": [self.a, self.b],
            "model_held": self.model_fixed,
            "noise": list(self.noise),
            "worth_per_second": list(self.worth),
            "detectable": [
                {key: None if value == float("inf") else value for key, value in asdict(one).items()}
                for one in self.detectable
            ],
        }

    def __repr__(self) -> str:
        smallest = self._smallest()
        never = sorted({one.joint for one in smallest if one.magnitude == float("inf")})
        note = f"; no motion shows it on joint {', '.join(map(str, never))}" if never else ""
        weak = [f"{one.effect} of joint {one.joint}" for one in smallest if one.beyond is not None]
        note += (
            f"; but this noise hides {', '.join(weak)}: what would show needs more torque than the drive has"
            if weak
            else ""
        )
        return "\n".join(
            [
                self.design.summary,
                f"Separates {self.a} from {self.b}; smallest magnitude that shows beside the rival, worst over its shapes;"
                f" the model is {'fixed' if self.model_fixed else 'refitted'}",
                "  joint  effect                        magnitude  unit          random motions need",
                *map(_row, smallest),
                f"verdict: {self.design.limits_verdict}{note}",
            ]
        )

    def _smallest(self) -> list[Detectable]:
        """For each joint and effect, the parameter that shows first, at the shape for which it shows last."""
        worst: dict[tuple[int, str], Detectable] = {}
        for one in self.detectable:
            key = (one.joint, one.effect)
            # several parameters of an effect: one that shows is enough; its shape is not known beforehand
            same_shape = [d for d in self.detectable if (d.joint, d.effect, d.shape) == (*key, one.shape)]
            best = min(same_shape, key=lambda d: d.magnitude)
            if key not in worst or best.magnitude > worst[key].magnitude:
                worst[key] = best
        return list(worst.values())


def _row(one: Detectable) -> str:
    never = one.magnitude == float("inf")
    magnitude = "     never" if never else f"{one.magnitude:10.3g}"
    usual = "never" if one.usual == float("inf") else f"{one.usual:.3g}"
    ratio = "" if never or one.usual == float("inf") else f"  ({one.usual / one.magnitude:.1f} times)"
    return f"  {one.joint:5d}  {one.effect:<28} {magnitude}  {one.unit:<12}  {usual}{ratio}"
