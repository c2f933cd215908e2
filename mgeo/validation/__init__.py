"""Validation of user input; each error message states the value, the expectation and the place.

`arguments` validates function arguments, `constructors` reads constructor parameters, `entries`
validates single entries of files, and `tables` validates whole files with pydantic models.
"""
