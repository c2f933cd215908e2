"""Telemetry: samples, files, columns, declared conventions and checks."""
