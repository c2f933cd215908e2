from .app import EXAMPLES as EXAMPLES
from .app import app as app
from .calibrate import FILES as FILES
from .files import write_together as write_together
from .verify import verification_document as verification_document
