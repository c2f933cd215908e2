from .app import EXAMPLES as EXAMPLES
from .app import app as app
from .check import compare_filters as compare_filters
from .files import Picked as Picked
from .show import plan_document as plan_document
from .show import print_plan as print_plan
from .show import write_figures as write_figures
