"""Commands ``mgeo attitude show``, ``export``, ``check`` and ``schema``."""
