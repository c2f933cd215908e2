"""Evaluations that may fail, and what is nondominated among them.

`evaluator` counts and survives failures, `failures` finds the candidates that fail, `dominance`
says which vectors no other dominates, `individuals` reads pymoo's individuals and designs.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
