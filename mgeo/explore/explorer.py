"""Data of the explorer: the solutions of a run, and evaluations of modified designs."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from threading import RLock

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from numpy.typing import ArrayLike

from mgeo.algorithms.variables import KINDS, Variables
from mgeo.figures.front import MAX_HOVER_TEXTS
from mgeo.figures.motion import get_motion
from mgeo.plugins.protocol import call_optional, get_column_names
from mgeo.plugins.view import View, build_view
from mgeo.report.loaded_run import load_run
from mgeo.report.solutions import select_figure_rows
from mgeo.runs.summary import ConstraintMargin, list_constraint_margins
from mgeo.store.atomic import encode_json, write_file
from mgeo.store.solution_file import build_solution_document


class Explorer:
    """Solutions of a run, with methods to evaluate, draw and save modified designs.

    The methods are thread-safe. A lock serializes evaluations, because a problem need not be
    thread-safe.

    Parameters
    ----------
    folder : path
        Run folder of ``mgeo solve``.
    save : path, optional
        Folder into which `save` writes, or a ``.json`` file, which sets both the folder and the
        default file name. Default: the run folder.
    problem : str, optional
        Problem of the run as ``module:Class``, required if the problem has no installed name. Other
        modules that a file specifies are not imported.

    Attributes
    ----------
    title : str
        Title that names problem, algorithm and seed.
    noun : str
        Word for a solution, such as "plan".
    variables : Variables
        Kinds, bounds and options of the design variables.
    names : tuple of str
        Names of the design variables, with units.
    objectives : tuple of str
        Names of the objectives, with units.
    rows : array of int, shape (n,)
        Row numbers of the shown solutions on the front, in ascending order; at most 2,000.
    X : array, shape (n, n_var)
        Designs of the shown solutions.
    default_position : int
        Position in `rows` of the solution to show first, the knee of the front.
    folder, file_name : Path, str
        Folder into which `save` writes, and the default file name.

    Raises
    ------
    FileNotFoundError
        If the folder contains no run, or the folder of `save` does not exist.
    ValueError, TypeError
        If a file of the run is damaged, the options of the problem are invalid, or the run found no
        solution.

    Examples
    --------
    >>> from mgeo.explore import Explorer
    >>> explorer = Explorer("runs/first")  # doctest: +SKIP
    >>> metrics, margins = explorer.evaluate(explorer.X[0])  # doctest: +SKIP
    """

    def __init__(
        self, folder: Path | str, *, save: Path | str | None = None, problem: str | None = None
    ) -> None:
        folder = Path(folder)
        loaded = load_run(folder, [problem] if problem else [])
        if loaded.default is None:
            raise ValueError(f"{folder} contains no solution: expected a run that found one")
        self.title, self.problem = loaded.title, loaded.problem
        self._problem_name = loaded.run.configuration.problem
        self._lock = RLock()
        self.rows = select_figure_rows(loaded.representatives, len(loaded.view.X), MAX_HOVER_TEXTS)
        self._view = loaded.view.select(self.rows)
        self.noun = self._view.noun
        self.X = self._view.X
        self.variables = Variables.from_problem(self.problem, KINDS)
        self.names, self.objectives = get_column_names(self.problem)
        self.default_position = int(np.searchsorted(self.rows, loaded.default.row))
        target = folder if save is None else Path(save)
        self.folder, self.file_name = target, "plan.json"
        if target.suffix == ".json":
            self.folder, self.file_name = target.parent, target.name
        if not self.folder.is_dir():
            raise FileNotFoundError(f"--save {target}: the folder {self.folder} does not exist")

    @cached_property
    def table(self) -> pd.DataFrame:
        """DataFrame with the objectives and quick metrics of each solution.

        Quick metrics are those of `View.quick_metrics`, with the titles of `View.format_title`. The
        index contains the row numbers of the solutions on the front.
        """
        with self._lock:
            return self._compute_metrics(self._view).set_axis(pd.Index(self.rows, name=self.noun))

    def evaluate(self, x: ArrayLike) -> tuple[dict[str, float], list[ConstraintMargin]]:
        """Evaluate a design, and return its metrics and constraint margins.

        Parameters
        ----------
        x : array_like, shape (n_var,)
            Design.

        Returns
        -------
        metrics : dict of str to float
            Objectives and quick metrics of the design, keyed by column of `table`.
        margins : list of ConstraintMargin
            Margin of the design with respect to each constraint.
        """
        with self._lock:
            view = self._build_view(x)
            (margins,) = list_constraint_margins(view)
            return extract_row(self._compute_metrics(view), 0), margins

    def build_figures(self, x: ArrayLike) -> dict[str, go.Figure]:
        """Return a dict of the figures of a design, without animations.

        Parameters
        ----------
        x : array_like, shape (n_var,)
            Design.
        """
        with self._lock:
            (figures,) = call_optional(self._build_view(x), View.solution_figures)
        return {name: figure for name, figure in figures.items() if get_motion(figure) is None}

    def save(self, x: ArrayLike, name: str) -> Path:
        """Save a design to a new JSON file, and return the path of the file.

        Parameters
        ----------
        x : array_like, shape (n_var,)
            Design.
        name : str
            Name of the new file in `folder`, ending in ``.json``.

        Raises
        ------
        ValueError
            If the name contains a folder or does not end in ``.json``.
        FileExistsError
            If the file exists.
        OSError
            If the file cannot be written.
        """
        path = self.folder / name
        if path.name != name or path.suffix != ".json":
            raise ValueError(f"file name {name!r:.80}: expected a name ending in .json")
        if path.exists():
            raise FileExistsError(f"{path} exists: choose another name")
        with self._lock:
            document = build_solution_document(
                self.problem, self._problem_name, np.asarray(x, float)
            )
        write_file(path, encode_json(document))
        return path

    def _build_view(self, x: ArrayLike) -> View:
        return build_view(self.problem, np.asarray(x, dtype=float)[None])

    def _compute_metrics(self, view: View) -> pd.DataFrame:
        table, objectives = (
            call_optional(view, View.quick_metrics).select_dtypes("number"),
            list(self.objectives),
        )
        if not set(objectives) <= set(table.columns):
            F = pd.DataFrame(view.F, columns=objectives, index=table.index)
            table = F.join(table.drop(columns=objectives, errors="ignore"))
        ordered = table[[*objectives, *table.columns.drop(objectives)]]
        return ordered.rename(columns=view.format_title)


def extract_row(table: pd.DataFrame, position: int) -> dict[str, float]:
    """Return one row of a numeric table as a dict that maps column names to values."""
    return {str(name): float(value) for name, value in table.iloc[position].items()}
