"""The error of everything here."""


class UncertainError(ValueError):
    """Something that may compute other values the next time; the message says what it is."""
