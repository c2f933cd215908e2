"""Improvement of maneuver plans without a global search: initial designs and local refinement."""
