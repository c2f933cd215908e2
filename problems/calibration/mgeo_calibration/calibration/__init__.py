"""What telemetry says of gyro and sensors: estimated, tested, written, drawn and read back."""
