"""Orbit, Sun, geomagnetic field and shadow of a run, all in GCRS."""
