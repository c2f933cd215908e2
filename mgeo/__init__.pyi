from .algorithms import MGEOCanonical as MGEOCanonical
from .algorithms import MGEODirected as MGEODirected
from .algorithms import MGEOReal as MGEOReal
from .algorithms import MGEOReal2 as MGEOReal2
from .algorithms import MGEOStaged as MGEOStaged
from .algorithms import MGEOVar as MGEOVar
from .algorithms.archive import ParetoArchive as ParetoArchive
from .algorithms.starting import SuggestedSampling as SuggestedSampling
from .evaluation.evaluator import EvaluationError as EvaluationError
from .evaluation.evaluator import TolerantEvaluator as TolerantEvaluator
from .plugins.view import View as View
from .plugins.view import view_of as view_of
from .store.checkpoint import Checkpoint as Checkpoint
from .store.checkpoint import resume as resume
from .store.recorder import Recorder as Recorder
from .store.recorder import read_record as read_record
from .studies import compare as compare

__version__: str
