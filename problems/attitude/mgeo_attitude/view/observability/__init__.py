"""Error budget, observability of the states, and possible improvements of a plan."""
