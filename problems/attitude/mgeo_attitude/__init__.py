"""Attitude maneuvers that make sensor errors observable, as a pymoo problem."""
