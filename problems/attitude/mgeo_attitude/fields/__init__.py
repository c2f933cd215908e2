"""Dataclass fields that know their meaning, unit and range, and are checked by pydantic.

One declaration refuses bad values, in a message that names them, reads tables, comments scenario
files and describes them to editors::

    eccentricity: float = quantity(doc="orbit eccentricity", low=0.0, high=1.0, open_high=True)
    # InvalidValue: eccentricity = 1.2: expected a number in [0, 1) (orbit eccentricity)
"""
