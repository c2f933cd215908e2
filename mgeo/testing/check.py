"""How a check of a plugin fails."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import ArrayLike


class CheckError(AssertionError):
    """A plugin breaks a rule; the message names the rule, the value and what was expected."""


def require(condition: bool | np.bool_, message: str) -> None:
    """Raise `CheckError` with `message` unless `condition` holds."""
    if not condition:
        raise CheckError(message)


def require_equal(found: ArrayLike, expected: ArrayLike, rule: str, rtol: float = 0.0) -> None:
    """Raise `CheckError` unless two arrays agree in shape and value, NaN being equal to NaN."""
    a, b = np.asarray(found, dtype=float), np.asarray(expected, dtype=float)
    require(a.shape == b.shape, f"{rule}: got shape {a.shape}, expected {b.shape}")
    same = np.isclose(a, b, rtol=rtol, atol=0, equal_nan=True)
    if not same.all():
        at = tuple(int(i) for i in np.argwhere(~same)[0])
        raise CheckError(f"{rule}: got {a[at]} at {at}, expected {b[at]}")


@contextmanager
def no_error(rule: str) -> Iterator[None]:
    """Raise a `CheckError` that begins with `rule` for any error."""
    try:
        yield
    except CheckError:
        raise
    except Exception as error:
        raise CheckError(f"{rule}: {type(error).__name__}: {error}") from error
