"""Telemetry: what a satellite has reported, its files, columns, units and frames."""
