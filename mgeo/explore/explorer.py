"""What the page asks of a run: its solutions in numbers, and designs that a hand has changed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from functools import lru_cache
from pathlib import Path

import numpy as np
import pandas as pd

from mgeo._typing import FloatArray
from mgeo.algorithms.variables import KINDS, Variables
from mgeo.evaluation.individuals import options_of
from mgeo.explore.saving import Saved
from mgeo.figures.front import MOST_TEXTS, logarithmic
from mgeo.plugins.problems import load_problem
from mgeo.plugins.protocol import column_names
from mgeo.plugins.shown import ask, cells
from mgeo.plugins.view import View, is_own, view_of
from mgeo.report.build import read_subject
from mgeo.report.solutions import Json, cell, figure_json, planned_rows, plans_json
from mgeo.runs.answer import Margin, default_solution, limits
from mgeo.store.solution_file import solution_document

_RECENT = 32  # designs whose views are kept: figures and limits of one share its evaluation


class Explorer:
    """A run folder as the page of `mgeo explore` asks it: JSON values in and out.

    Not for several threads at once: the problem may be none for them.

    Parameters
    ----------
    folder : path
        That `mgeo solve` wrote.
    save : path, optional
        A folder to write solutions into, or the ``.json`` file of the only one; default: `folder`.
    problem : str, optional
        The run's, if that is ``module:Class``: a file alone has no module imported.

    Raises
    ------
    FileNotFoundError
        If the folder holds no run, or there is no folder to save into.
    ValueError, TypeError
        If a file is damaged, the problem refuses its options, or the run found no solution.

    Examples
    --------
    >>> from mgeo.explore import Explorer
    >>> explorer = Explorer("runs/first")  # doctest: +SKIP
    >>> explorer.glance(explorer.view.X[0])["numbers"]  # doctest: +SKIP
    [1032.0, 0.00123]
    """

    def __init__(
        self, folder: Path | str, *, save: Path | str | None = None, problem: str | None = None
    ) -> None:
        folder, self._named = Path(folder), [problem] if problem else []
        self.run, self.problem, chosen, self.title = read_subject(folder, self._named)
        outcome = self.run.outcome
        if not len(outcome.X):
            raise ValueError(f"{folder} holds no solution: expected a run that found one")
        rows = planned_rows(chosen, len(outcome.X), MOST_TEXTS)
        self.numbers: list[int] = rows.tolist()
        self.view = view_of(self.problem, outcome.X, outcome.F).take(rows)
        self._labels = {solution.row: solution.label for solution in chosen}
        self._first = 0 if outcome.nearest else default_solution(self.problem, outcome.F).row
        self._place = {x.tobytes(): place for place, x in enumerate(self.view.X)}
        self._view = lru_cache(_RECENT)(self._made)
        self._told: list[str] | None = None
        self.saved = Saved(folder, None if save is None else Path(save))

    def another(self) -> Explorer:
        """One of the same run, as it was read, for another thread: its problem is its own."""
        found, configuration = copy(self), self.run.configuration
        found.problem = load_problem(
            configuration.problem, configuration.options, named=self._named
        )
        outcome = self.run.outcome
        found.view = view_of(found.problem, outcome.X, outcome.F).take(self.numbers)
        found._view = lru_cache(_RECENT)(found._made)
        return found

    def front(self) -> Json:
        """Numbers of all solutions, and what the page must know of the problem."""
        _, objectives = column_names(self.problem)
        table = self._numbers(self.view)
        kinds = ["objective"] * len(objectives) + ["told"] * (table.shape[1] - len(objectives))
        columns = [*objectives, *(self._told or ())]
        return {
            "title": self.title,
            "columns": [
                {"name": name, "kind": kind, "log": logarithmic(values[np.isfinite(values)])}
                for name, kind, values in zip(columns, kinds, table.T, strict=True)
            ],
            "rows": _finite(table),
            "designs": self.view.X.tolist(),
            "numbers": self.numbers,
            "labels": {str(row): label for row, label in self._labels.items()},
            "first": self._first,
            "variables": list(self._variables()),
            "nearest": len(self.run.outcome.nearest) > 0,
            "save": self.saved.proposal,
        }

    def limits(self, places: Sequence[int]) -> Json:
        """Limits of solutions by their places in the table of `front`."""
        if any(not 0 <= place < len(self.view.X) for place in places):
            raise ValueError(f"rows = {list(places)!r:.80}: expected 0 to {len(self.view.X) - 1}")
        return [list(map(_limit, each)) for each in limits(self.view.take(places))]

    def glance(self, x: FloatArray) -> Json:
        """Of a design, shape (n_var,), what is known at once: numbers as in `front`, limits."""
        view = self._of(x)
        (known,) = limits(view)
        return {"numbers": _finite(self._numbers(view))[0], "limits": list(map(_limit, known))}

    def figures(self, x: FloatArray) -> Json:
        """Of a design its own figures, by name."""
        found = plans_json(self._of(x), np.zeros(1, dtype=np.int64))
        return {"figures": found["common"]}  # of one nothing differs

    def answer(self, x: FloatArray) -> Json:
        """What a design is worth in one line, and all that is told of it; may take seconds."""
        view = self._of(x)
        table = ask(view, View.describe)
        (line,) = ask(view, View.answers)
        told = [[str(name), cell(value)] for name, value in table.iloc[0].items()]
        return {"answer": line, "described": told}

    def review(self, x: FloatArray) -> Json:
        """Sections of a design's review, such as its error budget; may take seconds."""
        found = ask(self._of(x), View.review)
        return {
            "sections": [
                {
                    "title": section.title,
                    "lines": list(section.lines),
                    "table": None if section.table is None else cells(section.table),
                    "note": section.note,
                }
                for section in found.sections
            ]
        }

    def pictures(self) -> Json:
        """Figures of all solutions, as the problem draws them; may take seconds."""
        found = ask(self.view, View.figures)
        return {str(name): figure_json(figure, lists=True) for name, figure in found.items()}

    def save(self, x: FloatArray, name: str, *, overwrite: bool) -> Json:
        """Write a design's file; see `mgeo.explore.saving`."""
        document = solution_document(self.problem, self.run.configuration.problem, x)
        path = self.saved.write(name, document, overwrite=overwrite)
        return {"file": str(path)}

    def design(self, given: Sequence[float]) -> FloatArray:
        """Numbers as a design, shape (n_var,).

        Raises
        ------
        ValueError
            Naming what is none, and what was expected.
        """
        known = list(self._variables())
        if len(given) != len(known):
            raise ValueError(f"design of {len(given)} numbers: expected {len(known)}")
        for j, (value, variable) in enumerate(zip(given, known, strict=True)):
            low, high = variable["low"], variable["high"]
            if low is not None and not low <= value <= high:
                raise ValueError(
                    f"design[{j}] = {value:.6g}: expected {low:.6g} to {high:.6g} for "
                    f"{variable['name']}"
                )
            if variable["kind"] != "real" and value != round(value):
                raise ValueError(
                    f"design[{j}] = {value:.6g}: expected a whole number for {variable['name']}"
                )
        return np.array(given, dtype=float)

    def _variables(self) -> Iterator[Mapping[str, Json]]:
        names, _ = column_names(self.problem)
        options = options_of(self.problem)
        try:
            known = Variables.of(self.problem, KINDS)
        except ValueError:  # without bounds there is nothing to slide along
            for name in names:
                yield {"name": name, "kind": "real", "low": None, "high": None, "options": None}
            return
        for name, kind, low, high in zip(
            names, known.kinds, known.xl.tolist(), known.xu.tolist(), strict=True
        ):
            words = [str(option) for option in options[name]] if kind == "choice" else None
            yield {"name": name, "kind": kind, "low": low, "high": high, "options": words}

    def _of(self, x: FloatArray) -> View:
        return self._view(x.tobytes())

    def _made(self, key: bytes) -> View:
        place = self._place.get(key)
        if place is not None:
            return self.view.take([place])
        return view_of(self.problem, [np.frombuffer(key)])

    def _numbers(self, view: View) -> FloatArray:
        """Objectives, then what else is told in numbers at a glance, shape (n, k)."""
        _, objectives = column_names(self.problem)
        table = ask(view, View.glance) if is_own(view, View.glance) else ask(view, View.describe)
        if self._told is None:  # of the whole front, first
            own = table if is_own(view, View.describe) else table.iloc[:, :0]
            self._told = [
                str(name)
                for name in own.columns
                if name not in objectives
                and pd.api.types.is_numeric_dtype(own[name])
                and not pd.api.types.is_bool_dtype(own[name])
            ]
        evaluated = "F" in view.__dict__ or not set(objectives) <= set(table.columns)
        F = view.F if evaluated else table[list(objectives)].to_numpy(float)
        return np.hstack([F, table[self._told].to_numpy(float).reshape(len(F), -1)])


def _limit(margin: Margin) -> Json:
    value = margin.margin if margin.value is None else margin.value
    bound, limit = (margin.bound, margin.limit) if margin.value is not None else ("at least", 0.0)
    return {
        "name": margin.name if margin.value is not None else f"margin of {margin.name}",
        "unit": margin.unit,
        "value": value if np.isfinite(value) else None,
        "bound": bound,
        "limit": limit,
        "kept": bool(margin.kept),
        "text": str(margin).removeprefix(f"{margin.name}: "),
    }


def _finite(table: FloatArray) -> list[list[float | None]]:
    return [[v if np.isfinite(v) else None for v in row] for row in table.tolist()]
