from .catalog import Catalog as Catalog
from .problem import SensorSuiteProblem as SensorSuiteProblem

__version__: str
