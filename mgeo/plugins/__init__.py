"""Plugins: problems, algorithms and commands that other distributions provide.

`discovery` lists and imports plugins, `problems` builds a problem from its name and options,
`protocol` defines the optional methods of a problem, `view` and `review` present solutions.
"""
