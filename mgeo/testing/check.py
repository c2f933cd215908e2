"""Exception of a failed plugin check, and functions that raise it."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import ArrayLike


class CheckError(AssertionError):
    """Error raised when a plugin violates a rule of a check.

    The message states the rule, the value and the expected value.
    """


def require(condition: bool | np.bool_, message: str) -> None:
    """Raise CheckError with a message if a condition is not satisfied."""
    if not condition:
        raise CheckError(message)


def require_equal(actual: ArrayLike, expected: ArrayLike, rule: str, rtol: float = 0.0) -> None:
    """Raise CheckError if two arrays differ in shape or value.

    Parameters
    ----------
    actual, expected : array_like
        Arrays to compare; NaN equals NaN.
    rule : str
        Beginning of the message.
    rtol : float
        Relative tolerance.
    """
    a, b = np.asarray(actual, dtype=float), np.asarray(expected, dtype=float)
    require(a.shape == b.shape, f"{rule}: got shape {a.shape}, expected {b.shape}")
    is_close = np.isclose(a, b, rtol=rtol, atol=0, equal_nan=True)
    if not is_close.all():
        at = tuple(int(i) for i in np.argwhere(~is_close)[0])
        raise CheckError(f"{rule}: got {a[at]} at {at}, expected {b[at]}")


@contextmanager
def convert_to_check_error(rule: str) -> Iterator[None]:
    """Context manager that converts any exception to a CheckError that states a rule."""
    try:
        yield
    except CheckError:
        raise
    except Exception as error:
        raise CheckError(f"{rule}: {type(error).__name__}: {error}") from error
