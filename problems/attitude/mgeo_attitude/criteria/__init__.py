"""Objectives and constraints of designs, for nominal runs and for Monte Carlo runs."""
