"""Commands ``mgeo attitude verify``, ``fly`` and ``calibrate``."""
