"""Complete trajectory of a plan, including the slew back to the initial attitude law."""
