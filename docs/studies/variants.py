"""Variants of `MGEODirected` with other constants, for comparison in studies.

A study that is run in the folder above docs refers to them as in ``name =
"docs.studies.variants:Former"``.
"""

from mgeo import MGEODirected


class Former(MGEODirected):
    """Former default, with random targets and a single threshold of progress."""

    target_selection = (0.5, 0.0)
    progress_threshold = (1e-3, 1e-3)


class NoCoupling(MGEODirected):
    coupling = (0.0, 0.0)


class OneCoupling(MGEODirected):
    coupling = (0.2, 0.2)


class OneWidth(MGEODirected):
    sigma_range = (0.05, 0.05)


class NoReturn(MGEODirected):
    return_probability = 0.0


class NoMigration(MGEODirected):
    migration_probability = (0.0, 0.0)


class OneMigration(MGEODirected):
    migration_probability = (0.1, 0.1)


class NoRestart(MGEODirected):
    patience = (100_000, 100_000)


class OneRestart(MGEODirected):
    patience = (15, 15)


class NoAttraction(MGEODirected):
    attraction = (0.0, 0.9)


class NearestTargets(MGEODirected):
    target_selection = (1.0, 0.33)


class AnyTargets(MGEODirected):
    target_selection = (0.0, 0.0)


class AnyProgress(MGEODirected):
    progress_threshold = (1e-12, 1e-12)


class OneMeasure(MGEODirected):
    progress_threshold = (1e-3, 1e-3)


class NoCovariance(MGEODirected):
    adaptive_share = 0.0


class NoRecombination(MGEODirected):
    recombination = (0.0, 0.0)


class OneRecombination(MGEODirected):
    recombination = (0.3, 0.3)
