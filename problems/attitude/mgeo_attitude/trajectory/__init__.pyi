from .arrival import arrival as arrival
from .arrival import missing as missing
from .trajectory import Search as Search
from .trajectory import SlewBack as SlewBack
from .trajectory import Trajectory as Trajectory
from .trajectory import slew_back as slew_back
