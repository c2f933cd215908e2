"""Commands of the plugin for the tests."""

from pathlib import Path
from typing import Annotated

import typer

from mgeo.cli.errors import convert_input_errors
from mgeo.cli.options import Debug, Json
from mgeo.terminal import Output

app = typer.Typer(help="Beams, weighed.", rich_markup_mode="rich")


@app.command()
def weigh(
    file: Annotated[Path, typer.Argument()],
    density: float = 7800.0,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Weigh a beam of [so much] volume."""
    with convert_input_errors():
        volume = float(file.read_text())
    output = Output(json=json)
    output.print(f"{file}: {density * volume:g} kg")
    output.print_document({"mass_kg": density * volume, "volume_ratio": 1.0 / volume})


@app.command()
def paint(color: str) -> None:
    """Paint it."""
