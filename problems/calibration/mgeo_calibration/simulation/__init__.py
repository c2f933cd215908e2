"""Monte Carlo simulation of the on-board error-state filter, with consistency tests."""
