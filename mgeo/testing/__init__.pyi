from .algorithm import Bowls as Bowls
from .algorithm import check_algorithm as check_algorithm
from .problem import CheckError as CheckError
from .problem import check_problem as check_problem
