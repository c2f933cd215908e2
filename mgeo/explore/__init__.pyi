from .explorer import Explorer as Explorer
from .saving import Exists as Exists
from .saving import Saved as Saved
from .server import ExplorerServer as ExplorerServer
from .server import Worker as Worker
