"""What no maneuver can beat: lower bounds of the covariance at all times, without a search."""

from mgeo_attitude.bound.assembly import limit, limit_of_starts
from mgeo_attitude.bound.curves import LimitCurves
from mgeo_attitude.bound.samples import NoLimit

__all__ = ["LimitCurves", "NoLimit", "limit", "limit_of_starts"]
