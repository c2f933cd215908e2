"""Rotations, quaternions and 3-vectors."""
