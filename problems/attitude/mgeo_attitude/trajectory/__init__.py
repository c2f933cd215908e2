"""A plan as a whole, to the end of its run or until the satellite is back at its attitude law."""
