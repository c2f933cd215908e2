"""What a problem of somebody else gives when it is asked, checked where it comes in.

The optional parts of a problem are listed in `mgeo.plugins.discovery`. A part that raises, or gives
something else than it should, is a `PluginError` that names it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mgeo._typing import FloatArray
from mgeo.plugins.discovery import PluginError

if TYPE_CHECKING:
    import pandas as pd
    import plotly.graph_objects as go
    from pymoo.core.problem import Problem


def indicator_space(problem: Problem) -> Callable[[ArrayLike], FloatArray] | None:
    """Its ``indicator_space``, which takes and gives shape (n, n_obj); None if it has none."""
    if getattr(problem, "indicator_space", None) is None:
        return None

    def checked(F: ArrayLike) -> FloatArray:
        given = _ask(problem, "indicator_space", F)
        try:
            points = np.asarray(given, dtype=float)
        except (TypeError, ValueError) as error:
            raise _unexpected(problem, "indicator_space(F)", given, "numbers") from error
        if points.shape != np.shape(F) or not np.isfinite(points).all():
            expected = f"finite numbers of shape {np.shape(F)}"
            raise _unexpected(problem, "indicator_space(F)", given, expected)
        return points

    return checked


def options(problem: Problem) -> dict[str, Any] | None:
    """Its ``options()``, None if it has none."""
    if not hasattr(problem, "options"):
        return None
    given = _ask(problem, "options")
    if not isinstance(given, dict) or not all(isinstance(key, str) for key in given):
        raise _unexpected(problem, "options()", given, "a dict with keys of type str")
    return given


def fingerprint(thing: Any) -> str:
    """The ``fingerprint`` by which a problem's or an algorithm's author vouches; empty for none."""
    given = getattr(thing, "fingerprint", None)
    if given is None:
        return ""
    if not isinstance(given, str) or not given:
        raise PluginError(
            f"fingerprint of {type(thing).__name__} = {given!r:.80}: expected a text that says "
            "what it computes"
        )
    return given


def describe(problem: Problem, X: NDArray[Any]) -> pd.DataFrame | None:
    """Its ``describe(X)``, one row for each of X; None if it has none."""
    import pandas as pd

    if not hasattr(problem, "describe"):
        return None
    given = _ask(problem, "describe", X)
    if not isinstance(given, pd.DataFrame) or len(given) != len(X):
        raise _unexpected(problem, "describe(X)", given, f"a DataFrame of {len(X)} rows")
    return given


def front_summary(problem: Problem, F: FloatArray) -> dict[str, float]:
    """Its ``front_summary(F)``, empty if it has none."""
    if getattr(problem, "front_summary", None) is None:
        return {}
    given = _ask(problem, "front_summary", F)
    numbers = isinstance(given, Mapping) and all(
        isinstance(value, int | float | np.number) for value in given.values()
    )
    if not numbers:
        raise _unexpected(problem, "front_summary(F)", given, "a dict of numbers")
    return {str(name): value for name, value in given.items()}


def front_figure(problem: Problem, X: NDArray[Any]) -> go.Figure | None:
    """The figure ``front`` of its ``figures(X)``, None if it has none."""
    if not hasattr(problem, "figures"):
        return None
    given = _ask(problem, "figures", X)
    if not isinstance(given, Mapping):
        raise _unexpected(problem, "figures(X)", given, "a dict of plotly figures")
    figure = given.get("front")
    return None if figure is None else _figure(problem, "figures(X)['front']", figure)


def solution_figures(problem: Problem, X: NDArray[Any]) -> list[dict[str, go.Figure]]:
    """Its ``solution_figures(X)``, one dict for each of X; empty if it has none."""
    if not hasattr(problem, "solution_figures") or not len(X):
        return []
    given = _ask(problem, "solution_figures", X)
    if (
        not isinstance(given, list)
        or len(given) != len(X)
        or not all(isinstance(figures, Mapping) for figures in given)
    ):
        raise _unexpected(problem, "solution_figures(X)", given, f"{len(X)} dicts of figures")
    return [
        {str(name): _figure(problem, "solution_figures(X)", f) for name, f in figures.items()}
        for figures in given
    ]


def _ask(problem: Problem, name: str, *arguments: Any) -> Any:
    try:
        given = getattr(problem, name)(*arguments)
        return list(given) if isinstance(given, Iterator) else given
    except Exception as error:  # whatever a problem raises: foreign code
        raised = f"{type(error).__name__}: {error}".removesuffix(": ")
        raise PluginError(f"{name} of problem {type(problem).__name__} raised {raised}") from error


def _figure(problem: Problem, name: str, given: Any) -> go.Figure:
    import plotly.graph_objects as go

    if not isinstance(given, go.Figure):
        raise _unexpected(problem, name, given, "a plotly figure")
    return given


def _unexpected(problem: Problem, name: str, given: Any, expected: str) -> PluginError:
    found = f"{type(given).__name__} of shape {np.shape(given)}" if _sized(given) else repr(given)
    return PluginError(
        f"{name} of problem {type(problem).__name__} gives {found:.80}: expected {expected}"
    )


def _sized(given: Any) -> bool:
    return isinstance(given, np.ndarray) or hasattr(given, "iloc")
