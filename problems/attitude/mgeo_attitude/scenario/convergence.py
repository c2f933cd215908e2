"""The rule by which a plan ends."""

from __future__ import annotations

from typing import Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from mgeo_attitude.settings.base import Settings
from mgeo_attitude.settings.types import Seconds


@dataclass(frozen=True, kw_only=True)
class Convergence(Settings):
    """When a plan ends: with its last maneuver, or later, once the filter has converged.

    Examples
    --------
    >>> from mgeo_attitude.scenario import Convergence
    >>> Convergence(rule="end").rule
    'end'
    """

    rule: Literal["trace", "required", "settling", "end"] = "trace"
    """what tells: the trace over a window; from when on required_sigma is met until the end of
    duration; from when on the trace stays within a factor of what it is then; or the end of the
    last maneuver alone"""
    factor: float = Field(default=1.25, gt=1.0)
    """that factor, for the rule settling"""
    window: Seconds = Field(default=300.0, gt=0.0)
    """window, a multiple of the step"""
    relative_decrease: float = Field(default=0.01, gt=0.0, lt=1.0)
    """converged if the trace fell by less than this fraction over the window, and did not rise"""
    allow_rise: bool = False
    """whether a trace that rose over the window counts as converged too"""

    @property
    def time(self) -> str:
        """What t_end is, in words."""
        return "a plan's end" if self.rule == "end" else "time to converge"
