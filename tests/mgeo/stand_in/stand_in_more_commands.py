"""Commands with which another distribution extends those of the plugin for the tests."""

import typer

app = typer.Typer()


@app.command()
def paint(color: str) -> None:
    """Paint it twice."""
    typer.echo(f"{color}, {color}")


@app.command()
def cut() -> None:
    """Cut it."""
