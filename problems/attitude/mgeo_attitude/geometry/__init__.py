"""Rotations, quaternions and vectors."""
