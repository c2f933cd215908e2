"""Orbit, Sun, Moon, geomagnetic field and eclipses of a run, in GCRS axes."""
