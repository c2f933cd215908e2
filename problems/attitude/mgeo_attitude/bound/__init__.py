"""What no maneuver can beat: lower bounds of the covariance at all times, without a search."""
