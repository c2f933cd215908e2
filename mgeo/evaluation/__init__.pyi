from .dominance import front_rows as front_rows
from .dominance import nondominated as nondominated
from .dominance import not_weakly_dominated as not_weakly_dominated
from .dominance import weakly_dominated_rows as weakly_dominated_rows
from .failures import Failure as Failure
