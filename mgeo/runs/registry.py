"""Registry of the built-in algorithms, for the command line and the documentation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

DEFAULT_ALGORITHM, ROBUST_ALGORITHM = "mgeo-directed", "mgeo-staged"


@dataclass(frozen=True)
class AlgorithmRecord:
    """Registry entry of a built-in algorithm.

    Attributes
    ----------
    name : str
        Name in studies and on the command line.
    label : str
        Name in reports and documentation.
    description : str
        Method, and when to use it, in one line.
    path : str
        ``module:Class``, imported when the algorithm is built.
    population_arguments : tuple of str
        Keyword arguments of a pymoo constructor that the parameter ``population`` sets. Empty if
        the parameters of the algorithm are those of the constructor.
    supports_constraints : bool
        Whether the algorithm supports constraints.
    candidates : str
        Kinds of candidates, in one sentence that precedes the list of parameters.
    """

    name: str
    label: str
    description: str
    path: str
    population_arguments: tuple[str, ...] = ()
    supports_constraints: bool = True
    candidates: str = ""


_POPULATION_SIZE, _REFERENCE_DIRECTIONS = ("pop_size",), ("ref_dirs",)
_DIRECTIONS_AND_SIZE = (*_REFERENCE_DIRECTIONS, *_POPULATION_SIZE)


#: Kinds of candidates of `mgeo.MGEODirected`, in the order in which they are drawn.
_CANDIDATES = (
    "Each candidate is of one of four kinds, drawn at random. A recombination combines two good "
    "points: archived points, or best points of walkers. A step with momentum is the sum of two "
    "random parts: one along the step that led to the walker's best point, one towards an archived "
    "point. A difference step is a random fraction of the difference between two good points. A "
    "Gaussian step is normally distributed. The share of recombinations adapts to their success."
)


def _build_mgeo_record(
    name: str, label: str, cls: str, description: str, candidates: str = ""
) -> AlgorithmRecord:
    path = f"mgeo.algorithms:{cls}"
    return AlgorithmRecord(name, label, description, path, candidates=candidates)


def _build_pymoo_record(
    name: str,
    label: str,
    module_path: str,
    description: str,
    population_arguments: tuple[str, ...] = _POPULATION_SIZE,
) -> AlgorithmRecord:
    path = f"pymoo.algorithms.{module_path}"
    return AlgorithmRecord(name, label, description, path, population_arguments)


#: Built-in algorithms, of mgeo and pymoo. Installed plugins add further algorithms by entry points.
RECORDS = (
    _build_mgeo_record(
        "mgeo-real",
        "MGEO_real",
        "MGEOReal",
        "published MGEO_real: Gaussian steps of one variable",
    ),
    _build_mgeo_record(
        "mgeo-real2",
        "MGEO_real2",
        "MGEOReal2",
        "published MGEO_real2: Gaussian steps of several sizes",
    ),
    _build_mgeo_record(
        "mgeo-canonical",
        "MGEO",
        "MGEOCanonical",
        "published MGEO: variables as bits, flips of one bit",
    ),
    _build_mgeo_record(
        "mgeo-var", "MGEO_var", "MGEOVar", "published MGEO_var: one bit flip in each variable"
    ),
    _build_mgeo_record(
        DEFAULT_ALGORITHM,
        "decomposition-based MGEO",
        "MGEODirected",
        "decomposition: one weight vector per walker; default",
        _CANDIDATES,
    ),
    _build_mgeo_record(
        ROBUST_ALGORITHM,
        "staged MGEO",
        "MGEOStaged",
        "low-fidelity evaluations first; default with --robust",
        _CANDIDATES,
    ),
    _build_pymoo_record(
        "nsga2",
        "NSGA-II",
        "moo.nsga2:NSGA2",
        "nondominated sorting, crowding; for 2 or 3 objectives",
    ),
    _build_pymoo_record(
        "nsga3",
        "NSGA-III",
        "moo.nsga3:NSGA3",
        "reference directions; for 3 or more objectives",
        _DIRECTIONS_AND_SIZE,
    ),
    _build_pymoo_record(
        "u-nsga3",
        "U-NSGA-III",
        "moo.unsga3:UNSGA3",
        "NSGA-III, tournaments; for any number of objectives",
        _DIRECTIONS_AND_SIZE,
    ),
    _build_pymoo_record(
        "spea2", "SPEA2", "moo.spea2:SPEA2", "strength Pareto selection; for 2 or 3 objectives"
    ),
    _build_pymoo_record(
        "sms-emoa",
        "SMS-EMOA",
        "moo.sms:SMSEMOA",
        "hypervolume contribution; for 2 or 3 objectives",
    ),
    _build_pymoo_record(
        "age-moea2",
        "AGE-MOEA-II",
        "moo.age2:AGEMOEA2",
        "estimated front geometry; for any front shape",
    ),
    AlgorithmRecord(
        "moead",
        "MOEA/D",
        "decomposition; does not support constraints",
        "pymoo.algorithms.moo.moead:MOEAD",
        _REFERENCE_DIRECTIONS,
        supports_constraints=False,
    ),
    _build_pymoo_record(
        "ctaea",
        "C-TAEA",
        "moo.ctaea:CTAEA",
        "two archives; designed for constrained problems",
        _REFERENCE_DIRECTIONS,
    ),
    _build_pymoo_record(
        "gde3", "GDE3", "moo.gde3:GDE3", "differential evolution; real variables only"
    ),
    _build_pymoo_record(
        "nsde",
        "NSDE",
        "moo.nsde:NSDE",
        "differential evolution, NSGA-II; real variables only",
    ),
    _build_pymoo_record(
        "mopso-cd",
        "MOPSO-CD",
        "moo.mopso_cd:MOPSO_CD",
        "particle swarm with crowding; real variables only",
    ),
    _build_pymoo_record(
        "cmopso", "CMOPSO", "moo.cmopso:CMOPSO", "competitive particle swarm; real variables only"
    ),
    AlgorithmRecord(
        "rvea",
        "RVEA",
        "reference vectors; for 3 or more objectives",
        "mgeo.runs.pymoo_algorithms:FrontRVEA",
        _REFERENCE_DIRECTIONS,
    ),
    _build_pymoo_record(
        "random",
        "random search",
        "soo.nonconvex.random_search:RandomSearch",
        "uniformly random points, as a baseline",
        ("n_points_per_iteration",),
    ),
)

#: Built-in algorithms by name.
ALGORITHMS: Mapping[str, AlgorithmRecord] = {record.name: record for record in RECORDS}
