from .arguments import decimal_point as decimal_point
from .arguments import did_you_mean as did_you_mean
from .tables import FileError as FileError
from .tables import Table as Table
from .tables import checked as checked
from .tables import entry as entry
