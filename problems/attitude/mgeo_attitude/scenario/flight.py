"""What is not known when a plan is flown."""

from __future__ import annotations

from dataclasses import dataclass

from mgeo_attitude.fields import Validated, expect, quantity


@dataclass(frozen=True, kw_only=True)
class FlightErrors(Validated):
    """Flights over which a plan is judged, each with errors drawn from these.

    Flight k of a seed is the same however many others there are.

    Examples
    --------
    >>> from mgeo_attitude.scenario import FlightErrors
    >>> FlightErrors(count=32, attitude_deg=5.0, rate_error_deg_s=0.01).quantile
    0.9
    """

    count: int = quantity(16, low=1, high=10_000, doc="number of flights, the same for all plans")
    seed: int = quantity(0, low=0, doc="seed of what is drawn")
    quantile: float = quantity(
        0.9,
        low=0.0,
        high=1.0,
        open_low=True,
        doc="share of the flights that must keep the value of an objective; 1 for the worst",
    )
    mean: bool = quantity(False, doc="whether objectives are means over the flights instead")
    kept: float = quantity(
        1.0, low=0.0, high=1.0, open_low=True, doc="share of the flights that must keep each limit"
    )
    grow: tuple[int, ...] = quantity(
        (),
        low=0,
        high=10_000,
        doc="how many there are in the stages of a search before its last; 0 for none but the "
        "exact one",
    )
    attitude_deg: float | None = quantity(
        None,
        unit="deg",
        low=0.0,
        high=180.0,
        doc="attitude error at the start, 1-sigma per axis; initial.attitude_deg if not given",
    )
    rate_error_deg_s: float | None = quantity(
        None,
        unit="deg/s",
        low=0.0,
        doc="error of all rates, 1-sigma per axis; the gyro's initial bias if not given",
    )
    maneuver_rate_error_deg_s: float = quantity(
        0.0, unit="deg/s", low=0.0, doc="error of the rate of each maneuver, 1-sigma per axis"
    )
    duration_error: float = quantity(
        0.0, unit="s", low=0.0, doc="error of the duration of each maneuver, 1-sigma"
    )
    start_delay: float = quantity(
        0.0,
        unit="s",
        low=0.0,
        high=31 * 86400.0,
        doc="greatest delay of the start, of which all are equally likely; 604800 for a plan that "
        "holds at any time of a week",
    )

    noise_spread: float = quantity(
        0.0,
        low=0.0,
        high=2.0,
        doc="by how much the noise of the gyro and of each sensor may be other than is believed: "
        "1-sigma of the logarithm of their ratio",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        counts = [*self.grow, self.count]
        expect(counts == sorted(counts), "grow", self.grow, f"ascending, up to {self.count}")

    def in_stage(self, stage: int | None) -> int:
        """Number of flights in a stage of a search, from 0; all after the last, or if None."""
        counts = [*self.grow, self.count]
        return self.count if stage is None else counts[min(stage, len(counts) - 1)]
