from .arguments import decimal_point as decimal_point
from .arguments import did_you_mean as did_you_mean
from .arguments import refuse_unknown as refuse_unknown
from .tables import FileError as FileError
from .tables import Table as Table
from .tables import checked as checked
from .tables import entry as entry
from .tables import errors_of as errors_of
