"""Checks of what a user passes in: each error names the value, what was expected, and where.

`arguments` are those of functions and constructors, `tables` what files hold, checked by pydantic.
"""
