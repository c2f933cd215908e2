"""The directed walkers with other constants, for studies that compare with them.

Of studies that are run in the folder above docs: ``name = "docs.studies.variants:Former"``.
"""

from mgeo import MGEODirected


class Former(MGEODirected):
    """What was the default before: any targets, and one measure of progress."""

    targets = (0.5, 0.0)
    progress = (1e-3, 1e-3)


class NoCoupling(MGEODirected):
    coupling = (0.0, 0.0)


class OneCoupling(MGEODirected):
    coupling = (0.2, 0.2)


class OneWidth(MGEODirected):
    widths = (0.05, 0.05)


class NoReturn(MGEODirected):
    return_to_best = 0.0


class NoMigration(MGEODirected):
    migrate = (0.0, 0.0)


class OneMigration(MGEODirected):
    migrate = (0.1, 0.1)


class NoRestart(MGEODirected):
    restart = (100_000, 100_000)


class OneRestart(MGEODirected):
    restart = (15, 15)


class NoAttraction(MGEODirected):
    attract = (0.0, 0.9)


class NearestTargets(MGEODirected):
    targets = (1.0, 0.33)


class AnyTargets(MGEODirected):
    targets = (0.0, 0.0)


class AnyProgress(MGEODirected):
    progress = (1e-12, 1e-12)


class OneMeasure(MGEODirected):
    progress = (1e-3, 1e-3)


class NoCovariance(MGEODirected):
    learning = 0.0


class NoRecombination(MGEODirected):
    recombination = (0.0, 0.0)


class OneRecombination(MGEODirected):
    recombination = (0.3, 0.3)
