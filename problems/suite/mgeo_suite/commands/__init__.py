"""Commands ``mgeo suite``."""
