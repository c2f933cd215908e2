"""Docstrings below the fields of a class, for generated schemas and their reference."""

import ast
from itertools import pairwise


def parse_field_docstrings(definition: ast.ClassDef) -> dict[str, str]:
    """Return a dict that maps the fields of a class to the docstrings below them.

    Parameters
    ----------
    definition : ast.ClassDef
        Syntax tree of the class. Fields of its bases are not included.
    """
    return {
        field.target.id: str(text.value.value)
        for field, text in pairwise(definition.body)
        if isinstance(field, ast.AnnAssign)
        and isinstance(field.target, ast.Name)
        and isinstance(text, ast.Expr)
        and isinstance(text.value, ast.Constant)
    }
