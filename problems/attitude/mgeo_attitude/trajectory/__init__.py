"""A plan as a whole, to the end of its run or until the satellite is back at its attitude law."""

from mgeo_attitude.trajectory.trajectory import SlewBack, Trajectory, slew_back

__all__ = ["SlewBack", "Trajectory", "slew_back"]
