"""Lower bounds of the covariance over all maneuver plans of a scenario, as functions of time."""
