from .fly import check_suite as check_suite
from .fly import fly as fly
from .simulation import Drawn as Drawn
from .simulation import Outside as Outside
from .simulation import simulate as simulate
from .vehicle import VEHICLES as VEHICLES
from .vehicle import Coiled as Coiled
from .vehicle import Vehicle as Vehicle
