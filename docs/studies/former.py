"""The directed walkers with constants that they had before, for studies that compare with them.

Of studies that are run in the folder above docs: ``name = "docs.studies.former:Former"``.
"""

from mgeo import MGEODirected


class Former(MGEODirected):
    """Momentum towards any archived point, and one measure of progress, however full the front."""

    targets = (0.5, 0.0)
    progress = (1e-3, 1e-3)
