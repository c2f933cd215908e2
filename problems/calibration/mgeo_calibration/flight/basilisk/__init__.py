"""Flights by Basilisk: rigid-body dynamics, reaction wheels and sensors that nobody here wrote.

Nothing of Basilisk is imported until something is flown, and nothing is ever downloaded.
"""
