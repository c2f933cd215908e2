"""Algorithms of the generalized extremal optimization family.

`real` and `binary` are the published variants, of `walkers`; `directed`, of the candidates that
`moves` makes, and `staged` are ours; `base` makes pymoo algorithms of them; `archive` keeps what is
nondominated; `state` captures and restores runs. What is not called MGEO here is what a variant of
one's own is made of.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
