from .collections import expanded as expanded
from .collections import short_name as short_name
from .shifted import ABOVE as ABOVE
from .shifted import BELOW as BELOW
from .shifted import Shifted as Shifted
