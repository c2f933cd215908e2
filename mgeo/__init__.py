"""Generalized extremal optimization for pymoo."""
