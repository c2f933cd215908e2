"""Where body axes may point along the way; `mgeo_attitude.criteria.constraints` measures it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from mgeo_attitude.environment.directions import DIRECTIONS, Cone
from mgeo_attitude.fields import Validated, expect, positive, quantity
from mgeo_attitude.geometry.vector import unit
from mgeo_attitude.scenario.settings import check_name


@dataclass(frozen=True, kw_only=True)
class PathLimit(Validated):
    """A cone around a body axis that a direction must stay out of, or in, along the whole plan.

    Of the Earth, a disc, the angle counts from the limb: inside of it it is negative. The Sun
    counts while it shines. The axis is where the filter believes it: the cone is kept with a margin
    of `attitude_sigmas` times the 1-sigma of the angle; equation (14) of docs/theory.md.

    Examples
    --------
    >>> from mgeo_attitude.scenario import PathLimit
    >>> PathLimit(name="camera", boresight=(0.0, 0.0, 1.0), half_angle_deg=20.0).sense
    'keep-out'
    """

    name: str = quantity("payload", doc="name of the limit, for people")
    reference: str = quantity(
        "sun",
        choices=tuple(DIRECTIONS),
        doc="direction that counts; of earth from the limb, of nadir from the Earth's center",
    )
    sense: str = quantity(
        "keep-out",
        choices=("keep-out", "keep-in"),
        doc="whether it must stay out of the cone or in it",
    )
    boresight: tuple[float, float, float] = quantity(doc="axis of the cone, body axes (any length)")
    half_angle_deg: float = quantity(
        unit="deg", low=0.0, high=180.0, open_low=True, open_high=True, doc="half-angle of the cone"
    )
    attitude_sigmas: float = quantity(
        3.0, low=0.0, doc="margin for the unknown attitude, in 1-sigmas of the angle; 0 is none"
    )

    may_exceed: float | None = positive(
        None, unit="s", doc="for how long in all, in whole steps, it may be exceeded; none is never"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        check_name(self.name)
        expect(any(self.boresight), "boresight", self.boresight, "a direction, not zero")

    @property
    def keep_in(self) -> bool:
        return self.sense == "keep-in"

    @property
    def label(self) -> str:
        """What is limited, for people: ``Sun off camera``, ``nadir in antenna``."""
        way = "in" if self.keep_in else "off"
        return f"{DIRECTIONS[self.reference].label} {way} {self.name}"

    @property
    def bound(self) -> float:
        """What an excess of `filter.path_limits` must not be above [rad]."""
        return math.radians(self.half_angle_deg) * (1.0 if self.keep_in else -1.0)

    def cone(self) -> Cone:
        """The cone, in rad."""
        half_angle = math.radians(self.half_angle_deg)
        return Cone(self.reference, unit(self.boresight), half_angle, self.keep_in)
