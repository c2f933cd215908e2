"""Plugins: problems, algorithms and commands of other distributions.

`discovery` finds them, `problems` builds a problem by its name, `protocol` has the optional parts
of a problem, `view` and `shown` what people are shown of solutions.
"""
