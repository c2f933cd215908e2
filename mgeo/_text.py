"""Formatting of messages, texts and numbers."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Sequence

#: Width of texts [columns].
TEXT_WIDTH = 80
_NUMBER = re.compile(r"([-+]?[\d.,]+(e[-+]?\d+)?|nan|inf|-|)( ± [\d.]+)?( ?%)?\*?", re.IGNORECASE)


def join_lines(text: str) -> str:
    """Join the nonempty lines of a text by spaces, after stripping each line."""
    return " ".join(filter(None, map(str.strip, text.splitlines())))


def wrap_text(text: str, indent: str = "", width: int = TEXT_WIDTH) -> str:
    """Wrap a text to `TEXT_WIDTH` or `width` columns, whichever is smaller.

    A number and its unit stay on one line. All lines but the first are indented.
    """
    lines = textwrap.wrap(
        re.sub(r"(?<=\d) (?=(%|deg|h|min|s)(\W|$))", "\N{NO-BREAK SPACE}", text),
        min(width, TEXT_WIDTH),
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return "\n".join(lines).replace("\N{NO-BREAK SPACE}", " ")


def format_key(title: str) -> str:
    """Convert the title of a column or section to a JSON key.

    No key begins with a digit: "90 % of runs" becomes ``in_90_percent_of_runs``. The ratio of a
    quantity to its lower bound has a key of its own, since the key of the title alone would be that
    of the bound.

    Examples
    --------
    >>> format_key("attitude 1-sigma [deg]"), format_key("ωx [deg/s]"), format_key("trace [-]")
    ('attitude_1sigma_deg', 'rate_x_deg_s', 'trace')
    >>> format_key("trace / lower bound [-]")
    'trace_ratio_to_lower_bound'
    """
    text = title.lower().replace("1-sigma", "1sigma").replace("%", "percent")
    text = re.sub("/ (lower )?bound", "ratio to lower bound", text)
    key = re.sub(r"[^a-z0-9]+", "_", text.replace("ω", "rate ")).strip("_")
    return f"in_{key}" if key[:1].isdigit() else key


def format_key_title(key: str) -> str:
    """Convert a JSON key to a column title, with the unit percent in brackets.

    Examples
    --------
    >>> format_key_title("in_90_percent_of_runs"), format_key_title("steered_runs_percent")
    ('90 % of runs', 'steered runs [%]')
    """
    text = re.sub(r"^in_(?=\d)", "", key)
    return re.sub("_percent$", " [%]", text).replace("percent", "%").replace("_", " ")


def format_column(
    values: Sequence[object], decimals: int | None = None, digits: int = 3
) -> list[str]:
    """Format the values of a column for display.

    Parameters
    ----------
    values : sequence
        Numbers and texts. NaN becomes an empty text.
    decimals : int, optional
        Number of decimals of floats. By default, a column of integral numbers has none, and all
        other numbers have `digits` significant digits.
    digits : int
        Number of significant digits.
    """
    finite = [value for value in values if isinstance(value, float) and math.isfinite(value)]
    if decimals is None and all(n.is_integer() and abs(n) < 1e6 for n in finite):
        decimals = 0
    return [
        format_number(value, decimals, digits) if isinstance(value, float) else str(value)
        for value in values
    ]


def format_number(value: float, decimals: int | None = None, digits: int = 3) -> str:
    """Format a number with a given number of significant digits or decimals.

    Integer digits are not rounded below a million. NaN becomes an empty text.

    Examples
    --------
    >>> format_number(1234.5), format_number(0.0336), format_number(2.048e-06), format_number(1.1)
    ('1234', '0.0336', '2.05e-06', '1.10')
    """
    if math.isnan(value):
        return ""
    if math.isinf(value) or not (value == 0.0 or 1e-3 <= abs(value) < 1e6):
        return f"{value:.{digits - 1}e}" if decimals is None else f"{value:.{decimals}f}"
    if decimals is None:
        exponent = int(f"{value:.{digits - 1}e}".partition("e")[2])  # after rounding
        decimals = max(digits - 1 - exponent, 0) if value else 0
    return f"{value + 0.0:.{decimals}f}"


def format_two_digits(value: float) -> str:
    """Format a positive number with two significant digits.

    Digits before the decimal point are always kept.

    Examples
    --------
    >>> format_two_digits(0.5), format_two_digits(123.4), format_two_digits(2.04e-7)
    ('0.50', '123', '2.0e-07')
    """
    if value < 1e-5:
        return f"{value:.1e}" if value else "0"
    digits = 1 - math.floor(math.log10(float(f"{value:.1e}")))
    return f"{value:.{max(digits, 0)}f}"


def format_duration(seconds: float) -> str:
    """Format a duration [s] in hours, minutes and seconds, such as "1 h 40 min 5 s"."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    parts = [(hours, "h"), (minutes, "min"), (rest, "s")]
    return " ".join(f"{value} {unit}" for value, unit in parts if value) or (
        "less than 1 s" if seconds else "0 s"
    )


def is_number(text: str) -> bool:
    """Return True if a text is a number, a mean ± standard deviation, a hyphen, or empty.

    A star may follow, which marks a number.
    """
    return _NUMBER.fullmatch(text) is not None
