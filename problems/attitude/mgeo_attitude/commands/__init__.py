"""``mgeo attitude``: from a front to a plan that is flown."""
