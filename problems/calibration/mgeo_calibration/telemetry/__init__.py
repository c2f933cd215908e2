"""Telemetry tables: samples, files, columns, declared conventions and checks."""
