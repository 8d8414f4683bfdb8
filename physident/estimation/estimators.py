"""The estimators by their public names, with their settings: the methods of ``identify``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import Annotated, Any, ClassVar, Literal, cast

from physident.errors import InputError, did_you_mean
from physident.estimation.physical.bounds import Bound, Box, Ellipsoid
from physident.estimation.physical.prior import Entropic, Prior, make_prior, prior_from_dict
from physident.json_records import Range, RecordReader

HUBER = 1.345  # standard deviations: 95 % efficient for Gaussian noise, Huber "Robust Statistics" (1981), sec. 4.5


@dataclass(frozen=True)
class OLS:
    """Ordinary least squares: every joint's torque in N m counts alike (thesis eq. 3.64)."""

    name: ClassVar[str] = "ols"


@dataclass(frozen=True)
class WLS:
    """Weighted least squares, iterated until the weights settle.

    ``noise`` "diagonal" weighs each joint by its own residual; "full" whitens with the covariance between joints.
    """

    noise: Literal["diagonal", "full"] = "diagonal"

    name: ClassVar[str] = "wls"

    def __post_init__(self) -> None:
        _among("wls: noise", self.noise, ("diagonal", "full"))


@dataclass(frozen=True)
class Robust:
    """Huber's estimator by iterated reweighting: beyond ``threshold`` standard deviations a residual counts linearly.

    The standard deviation of each joint is that of its middle half (1.4826 times the median of |residual|).
    """

    threshold: float = HUBER

    name: ClassVar[str] = "robust"

    def __post_init__(self) -> None:
        _positive("robust: threshold", self.threshold, "standard deviations")


@dataclass(frozen=True)
class Physical:
    """The most likely parameters among the physically consistent ones.

    Every link's pseudo-inertia is positive semidefinite, rotor inertias are not negative, the friction of each joint
    dissipates at every speed, and the cones of all other effects hold. ``prior`` states how far nominal values are
    trusted; ``loss`` "huber" limits the influence of outliers. Further constraints are optional: ``total_mass`` [kg] of
    the moving links, ``bounding_volumes`` that contain a link, ``bounds`` of single parameters. Standard errors come from
    a block bootstrap with ``resamples`` (0: linearised), drawn with ``seed``.
    """

    prior: Prior = field(default_factory=Entropic)
    loss: Literal["squares", "huber"] = "squares"
    total_mass: float | None = None
    bounding_volumes: tuple[Ellipsoid | Box, ...] = ()
    bounds: tuple[Bound, ...] = ()
    resamples: int = 100
    seed: int = 0

    name: ClassVar[str] = "physical"

    def __post_init__(self) -> None:
        _among("physical: loss", self.loss, ("squares", "huber"))
        if self.total_mass is not None:
            _positive("physical: total_mass", self.total_mass, "kg")
        if self.resamples < 0 or self.resamples == 1:
            raise InputError(f"physical: resamples is {self.resamples}, expected 0 (linearised) or at least 2")


Estimator = OLS | WLS | Robust | Physical
VOLUMES = {"Ellipsoid": Ellipsoid, "Box": Box}
READER = RecordReader("identify it again")
ESTIMATORS: dict[str, Callable[..., Estimator]] = {e.name: e for e in (OLS, WLS, Robust, Physical)}


def make_estimator(method: str | Estimator) -> Estimator:
    """The estimator of a name with its default settings, or the ready-made one; raises InputError for another name."""
    if isinstance(method, OLS | WLS | Robust | Physical):
        return method
    if method not in ESTIMATORS:
        raise InputError(
            f"method {method!r} is unknown, expected one of {', '.join(ESTIMATORS)}{did_you_mean(method, ESTIMATORS)}"
        )
    return ESTIMATORS[method]()


def estimator_from_options(
    method: str, prior: str, prior_weight: str | None, loss: str, total_mass: float | None
) -> Estimator:
    """The estimator of the command line's options; raises InputError for options of another method."""
    if method != Physical.name:
        if (prior, prior_weight, loss, total_mass) != (Entropic.name, None, "squares", None):
            raise InputError(
                f"--prior, --prior-weight, --loss and --total-mass belong to --method physical, not to {method}"
            )
        return make_estimator(method)
    weight: Any = prior_weight
    if prior_weight not in (None, "auto"):
        try:
            weight = float(prior_weight)
        except ValueError:
            raise InputError(f"--prior-weight is {prior_weight!r}, expected a positive number or auto") from None
    return Physical(make_prior(prior, weight), cast(Any, loss), total_mass)


def estimator_as_dict(estimator: Estimator) -> dict[str, Any]:
    """Name and settings of an estimator as plain numbers, texts and lists for JSON."""
    data: dict[str, Any] = {"method": estimator.name, **asdict(estimator)}
    if isinstance(estimator, Physical):
        data["prior"] = estimator.prior.as_dict()
        del data["bounding_volumes"]
        data["shapes"] = [{"shape": type(v).__name__, **asdict(v)} for v in estimator.bounding_volumes]
    return data


def estimator_from_dict(data: dict[str, Any]) -> Estimator:
    """The estimator that ``estimator_as_dict`` described; raises InputError, naming the entry, for a wrong value."""
    method = READER.read(str, data["method"], "estimator.method")
    settings = {key: value for key, value in data.items() if key != "method"}
    for name in ("resamples", "seed"):
        if name in settings:
            READER.read(Annotated[int, Range(0)], settings[name], f"estimator.{name}")
    if method == Physical.name:
        volumes, bounds = settings.pop("shapes"), settings["bounds"]
        settings["prior"] = prior_from_dict(settings["prior"])
        settings["bounding_volumes"] = tuple(
            READER.read(VOLUMES[volume["shape"]], volume, f"estimator.shapes[{i}]") for i, volume in enumerate(volumes)
        )
        settings["bounds"] = READER.read(tuple[Bound, ...], bounds, "estimator.bounds")
    if method not in ESTIMATORS:
        raise InputError(f"estimator.method is {method!r}, expected one of {', '.join(ESTIMATORS)}; {READER.remedy}")
    return ESTIMATORS[method](**settings)


def _among(what: str, value: str, allowed: tuple[str, ...]) -> None:
    if value not in allowed:
        raise InputError(f"{what} is {value!r}, expected one of {', '.join(allowed)}{did_you_mean(value, allowed)}")


def _positive(what: str, value: float, unit: str) -> None:
    if not 0 < value < float("inf"):
        raise InputError(f"{what} is {value}, expected a positive number [{unit}]")
