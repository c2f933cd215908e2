"""Problems and commands of others.

`discovery` finds them and says what a plugin may bring, `problems` builds a problem by its name,
`view` is what people are shown of its solutions, `protocol` and `shown` check what a problem and
its view give when they are asked, `checks` are for authors.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
