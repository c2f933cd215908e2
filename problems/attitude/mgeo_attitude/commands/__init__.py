"""Commands ``mgeo attitude``: select, analyze and export a plan."""
