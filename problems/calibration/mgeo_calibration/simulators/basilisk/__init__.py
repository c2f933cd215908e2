"""Simulated runs by Basilisk, an independent simulator of dynamics, reaction wheels and sensors.

Basilisk is imported only when a run is simulated, and nothing is downloaded.
"""
