from .causes import causes as causes
from .causes import channel_causes as channel_causes
from .causes import checks as checks
