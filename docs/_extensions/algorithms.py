"""Directives ``algorithms``, a table of all algorithms, and ``algorithm-parameters``, a table of
the parameters of one algorithm, from its docstring.
"""

from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from mgeo.runs.algorithms import describe_algorithm
from mgeo.runs.registry import RECORDS


def format_algorithms() -> str:
    """Return a table with one row for each algorithm of mgeo and of pymoo."""
    rows = (f"| `{each.name}` | {each.label} | {each.description} |" for each in RECORDS)
    return "\n".join(["| name | algorithm | description |", "| --- | --- | --- |", *rows])


def format_parameters(name: str) -> str:
    """Return a table with one row for each parameter of an algorithm."""
    rows = (
        f"| `{each['name']}` | `{_format_default(each['default'])}` | {each['meaning']} |"
        for each in describe_algorithm(name)["parameters"]
    )
    return "\n".join(["| parameter | default | meaning |", "| --- | --- | --- |", *rows])


def _format_default(value: Any) -> str:
    return f'"{value}"' if isinstance(value, str) else str(value)


class AlgorithmTable(SphinxDirective):
    """Table of all algorithms."""

    def run(self) -> list[nodes.Node]:
        return self.parse_text_to_nodes(format_algorithms())


class ParameterTable(SphinxDirective):
    """Table of the parameters of the algorithm with the name that is the argument."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        return self.parse_text_to_nodes(format_parameters(self.arguments[0]))


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("algorithms", AlgorithmTable)
    app.add_directive("algorithm-parameters", ParameterTable)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
