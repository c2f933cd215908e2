"""Command ``mgeo schema``: JSON Schemas of study files and of JSON documents."""

from __future__ import annotations

from typing import Annotated

import typer

from mgeo.cli import options
from mgeo.cli.errors import convert_input_errors
from mgeo.terminal import format_json

#: Name of the schema of study files.
STUDY_FILE = "study.toml"


def schema(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME",
            help="Schema to print: study.toml, a file such as plan.json, or the --json output of a "
            "command, such as solve or attitude-show [default: list all names].",
        ),
    ] = None,
    debug: options.Debug = False,
) -> None:
    """Print the JSON Schema of study files, of result files, or of --json output.

    Editors with Taplo find the schema of study files by the first line of a file: #:schema
    ./study.schema.json
    """
    from mgeo.studies.schema import build_study_schema
    from mgeo.validation.arguments import validate_choice
    from mgeo.validation.documents import collect_documents

    documents = collect_documents()
    names = [STUDY_FILE, *documents]
    if name is None:
        typer.echo("\n".join(names))
        return
    with convert_input_errors():
        validate_choice("NAME", name, names)
    text = (
        build_study_schema() if name == STUDY_FILE else format_json(documents[name].build_schema())
    )
    typer.echo(text)
