"""Flights: what is true of a plan that is flown, and what gyro and sensors report of it."""
