"""Lower bounds of the covariance over all maneuver plans, as functions of time."""
