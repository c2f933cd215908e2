from .problem import problem_files as problem_files
from .problem import write_problem as write_problem
