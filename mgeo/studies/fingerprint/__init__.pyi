from .modules import UncertainError as UncertainError
from .modules import distinct as distinct
from .parts import fingerprint as fingerprint
