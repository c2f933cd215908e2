"""Text for messages."""


def one_line(text: str) -> str:
    """Join the lines of a text, each stripped; blanks within a line stay."""
    return " ".join(filter(None, map(str.strip, text.splitlines())))
