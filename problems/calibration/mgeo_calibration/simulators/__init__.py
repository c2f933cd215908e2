"""Simulators of plans: true attitude and errors, and the telemetry of gyro and sensors."""
