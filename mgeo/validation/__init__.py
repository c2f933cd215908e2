"""Checks of user input: each error names the value, what was expected, and where.

`arguments` checks arguments of functions, `entries` entries of files, `tables` whole files by
pydantic models.
"""
