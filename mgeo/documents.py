"""Declarations of the JSON documents that the commands of `mgeo` print with ``--json``."""

from __future__ import annotations

from typing import Any, Literal, NotRequired

from typing_extensions import TypedDict

from mgeo.store.run import Outcome, RunConfiguration
from mgeo.store.run_folder import RunDocument
from mgeo.validation.documents import Document, extensible


@extensible
class ConstraintRow(TypedDict):
    """Constraint of one solution."""

    constraint: str
    """Name of the constraint."""
    unit: str
    """Unit of value, bound and margin; empty or "-" if there is none."""
    value: float | None
    """Value of the constrained quantity; null if the problem reports margins only."""
    bound_type: str
    """"at most" or "at least"."""
    bound_value: float | None
    """Bound of the value; null like `value`."""
    margin: float | None
    """Distance to the bound, negative if the constraint is violated."""


@extensible
class Recommended(TypedDict):
    """Recommended solution of a front.

    This is the knee or, if the front has no knee, the solution with the best first objective.
    Further keys are tables of the problem, with one object per row. The problem `attitude` has
    `accuracy` and `maneuvers`; a problem without tables of its own has `values`.
    """

    solution: int
    """Number of the solution: its row in front.csv, from 0."""
    label: str
    """Reason of the recommendation, such as "knee"."""
    summary: str
    """Summary of the solution in one line."""
    constraints: list[ConstraintRow]
    """Constraints of the solution."""


@extensible
class FrontRow(TypedDict):
    """One of several representative solutions of a front.

    Further keys are quantities of the problem, with the unit at the end of the key. The problem
    `attitude` has `converges_after_s` (`ends_after_s` with the convergence rules `end` and
    `required`), `attitude_1sigma_deg`, `weighted_trace` and, if a lower bound is available,
    `trace_ratio_to_lower_bound`.
    """

    solution: int
    """Number of the solution: its row in front.csv, from 0."""
    label: str
    """Reason of the selection, such as "min-time", "knee" or "intermediate"."""
    violated: list[str]
    """Names of violated constraints, which the problem reports in addition to those of the
    search."""


@extensible
class Violation(TypedDict):
    """Constraint that is violated in a run without a feasible solution.

    The values describe the solutions nearest to feasibility, which nearest.csv contains.

    Further keys are `unit`, `value` and `bound`, if the problem reports them.
    """

    constraint: str
    """Name of the constraint."""
    violation: float | None
    """Smallest violation among the solutions nearest to feasibility."""
    violated_by: str
    """Number of these solutions that violate the constraint, such as "12 of 30"."""


class Infeasibility(TypedDict):
    """Analysis of a run that found no feasible solution."""

    violations: list[Violation]
    """Violated constraints."""
    suggestions: list[str]
    """Suggestions to make the problem feasible, one sentence each."""


class RunSummary(TypedDict):
    """Summary of a run."""

    folder: str
    """Run folder."""
    files: list[str]
    """Names of the files in the run folder."""
    recommended: Recommended | None
    """Recommended solution; null if no solution is feasible."""
    front: list[FrontRow]
    """About five representative solutions of the front, sorted by the first objective."""
    infeasibility: Infeasibility | None
    """Violated constraints and suggestions; null if there is a feasible solution."""
    warnings: list[str]
    """Warnings, each with what to do."""


class ImpossibleDocument(TypedDict):
    """Result of a run that cannot start because no design satisfies the constraints."""

    infeasibility_reasons: list[str]
    """Reasons, one sentence each."""


class ProblemSize(TypedDict):
    """Size of a problem."""

    variables: list[str]
    """Names of the variables, with units in brackets."""
    objectives: list[str]
    """Names of the objectives, with units in brackets."""
    constraints: int
    """Number of constraints."""


class DryRun(TypedDict):
    """Description of a run that has not been started."""

    dry_run: Literal[True]
    """Always true."""
    configuration: RunConfiguration
    """All settings of the run, defaults included."""
    facts: dict[str, str]
    """Properties of the problem, keyed by name."""
    warnings: list[str]
    """Warnings about the problem, each with what to do."""
    folder: str
    """Folder that the run would write."""
    files: list[str]
    """Names of the files that the run would write."""


class ReportDocument(TypedDict):
    """Files of a report."""

    folder: NotRequired[str]
    """Folder of the run or the study."""
    compared: NotRequired[list[str]]
    """Both runs or solution files, if two are compared; in place of `folder`."""
    file: str | None
    """Path of the page; null if only figures were written."""
    bytes: int
    """Size of the page that was written; 0 if only figures were written."""
    figures: list[str]
    """Paths of the figures of `--png`, `--pdf`, `--figure` and `--paper`."""


class ProblemRow(ProblemSize):
    """Installed problem."""

    name: str
    """Name for `mgeo solve`."""
    distribution: str
    """Package that contains the problem."""
    version: str
    """Version of the package."""
    presets: dict[str, str]
    """Descriptions of the presets for `--scenario`, by name."""
    error: str | None
    """Reason why the problem cannot be loaded, otherwise null."""


class ProblemsDocument(TypedDict):
    """Installed problems."""

    problems: list[ProblemRow]
    """Problems, sorted by name."""


class Parameter(TypedDict):
    """Parameter of an algorithm."""

    name: str
    """Name for `--set`."""
    default: Any
    """Default: a number, a text, true or false, a list, or null."""
    meaning: str
    """Meaning and permitted values."""


class AlgorithmDocument(TypedDict):
    """Algorithm and its parameters."""

    name: str
    """Name for `--algorithm`."""
    label: str
    """Name in texts and figures."""
    library: str
    """Package that contains the algorithm, such as "mgeo" or "pymoo"."""
    description: str
    """Method and use in one line."""
    parameters: list[Parameter]
    """Parameters."""


class AlgorithmRow(AlgorithmDocument):
    """Entry in the list of all algorithms."""

    error: str | None
    """Reason why the algorithm cannot be loaded, otherwise null."""


class AlgorithmsDocument(TypedDict):
    """All algorithms."""

    algorithms: list[AlgorithmRow]
    """Algorithms of mgeo, of pymoo and of installed plugins."""


class RankRow(TypedDict):
    """Average rank of one algorithm in a study, with comparisons to the reference algorithm."""

    algorithm: str
    """Label of the algorithm."""
    average_rank: float
    """Average rank over the problems; 1 is the best."""
    best_on: int
    """Number of problems on which the algorithm has the best median."""
    better: float | None
    """Number of problems on which the algorithm is significantly better than the reference
    algorithm: the control of the study or the best algorithm. Null for the reference algorithm."""
    equal: float | None
    """Number of problems without a significant difference to the reference algorithm."""
    worse: float | None
    """Number of problems on which the algorithm is significantly worse than the reference
    algorithm."""
    p_holm: float | None
    """p value of the difference in rank to the reference algorithm, with Holm's correction."""


class Statistics(TypedDict):
    """Statistics of one indicator over the runs of one algorithm."""

    mean: float | None
    """Mean."""
    sd: float | None
    """Sample standard deviation; null for a single run."""
    median: float | None
    """Median."""
    min: float | None
    """Smallest value."""
    max: float | None
    """Largest value."""


class ProblemResults(TypedDict):
    """Results of all algorithms on one problem of a study."""

    n_finished: int
    """Number of finished runs."""
    n_failed: int
    """Number of failed runs."""
    conclusions: list[str]
    """Conclusions, one sentence each."""
    ranking: list[str]
    """Labels of the algorithms, best mean rank first."""
    algorithms: dict[str, dict[str, Statistics]]
    """Statistics, keyed by algorithm label and by indicator, such as "hypervolume"."""


class StudyDocument(TypedDict):
    """Results of a study."""

    title: str
    """Title of the study."""
    folder: str
    """Folder of the study."""
    report: str
    """Path of the HTML report."""
    evaluations: int
    """Number of evaluations of each run."""
    per_variable: bool
    """Whether `evaluations` is multiplied by the number of variables of each problem."""
    seeds: list[int]
    """Seeds of the runs."""
    conclusions: list[str]
    """Conclusions over all problems, one sentence each."""
    warnings: list[str]
    """Warnings about the comparison, one sentence each."""
    ranks: list[RankRow]
    """Ranks of the algorithms over all problems, best first."""
    problems: dict[str, ProblemResults]
    """Results, keyed by problem label."""


class StudyDryRun(TypedDict):
    """Description of a study that has not been started."""

    dry_run: Literal[True]
    """Always true."""
    title: str
    """Title of the study."""
    problems: dict[str, ProblemSize]
    """Sizes of the problems, keyed by label."""
    algorithms: list[str]
    """Labels of the algorithms."""
    evaluations: int
    """Number of evaluations of each run."""
    per_variable: bool
    """Whether `evaluations` is multiplied by the number of variables of each problem."""
    n_runs: int
    """Number of runs."""
    folder: str
    """Folder that the study would write."""


class ExploreDocument(TypedDict):
    """Web address and folders of the interactive explorer."""

    url: str
    """Address of the page."""
    folder: str
    """Run folder."""
    save: str
    """Folder into which the page saves solutions."""


DOCUMENTS = {
    "solve": Document("mgeo solve, mgeo resume", (RunSummary, RunDocument, Outcome)),
    "solve-impossible": Document("mgeo solve, if no design is feasible", (ImpossibleDocument,)),
    "solve-dry-run": Document("mgeo solve --dry-run", (DryRun, ProblemSize)),
    "report": Document("mgeo report", (ReportDocument,)),
    "explore": Document("mgeo explore", (ExploreDocument,)),
    "problems": Document("mgeo problems", (ProblemsDocument,)),
    "algorithms": Document("mgeo algorithms", (AlgorithmsDocument,)),
    "algorithm": Document("mgeo algorithms NAME", (AlgorithmDocument,)),
    "study": Document("mgeo study", (StudyDocument,)),
    "study-dry-run": Document("mgeo study --dry-run", (StudyDryRun,)),
    "run.json": Document("run.json", (RunDocument, Outcome)),
}
