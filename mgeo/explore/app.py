"""Dash application of the explorer, with the callbacks of its page."""

from __future__ import annotations

import secrets
from time import perf_counter
from typing import Any

import plotly.graph_objects as go
from dash import ALL, Dash, Input, Output, State, html, set_props
from dash.development.base_component import Component

from mgeo._text import join_lines
from mgeo.explore import figures, layout
from mgeo.explore.explorer import Explorer, extract_row
from mgeo.plugins.review import format_cells

MAX_ROWS = 200  # maximum number of rows of the table
#: Evaluation time [s] up to which designs are evaluated while sliders move, not only afterwards.
MAX_EVALUATION_TIME = 0.2


def build_app(explorer: Explorer) -> Dash:
    """Create the Dash application that serves the explorer page.

    The path of the URL is random, and requests to other host names than 127.0.0.1 and localhost are
    refused. Hence neither other users of this machine nor other pages in the browser can access the
    application.

    Parameters
    ----------
    explorer
        Solutions and evaluations that the page shows.
    """
    app = Dash(
        "mgeo.explore",
        title=explorer.title,
        update_title="",
        url_base_pathname=f"/{secrets.token_urlsafe(16)}/",
        on_error=lambda error: _show_message(str(error)),
    )
    app.server.config["TRUSTED_HOSTS"] = ["127.0.0.1", "localhost"]
    app.layout = layout.build_page(explorer)
    _add_filter(app, explorer)
    _add_front(app, explorer)
    _add_design(app, explorer)
    return app


def _add_filter(app: Dash, explorer: Explorer) -> None:
    table = explorer.table

    @app.callback(Output("parallel", "figure"), Input("axes", "value"))
    def draw_axes(axes: list[str]) -> go.Figure:
        return figures.draw_parallel_coordinates(table, axes)

    @app.callback(
        Output("visible-rows", "data"),
        Input("parallel", "restyleData"),
        Input("parallel", "figure"),
    )
    def filter_rows(_: Any, figure: dict[str, Any]) -> list[int]:
        return figures.select_rows(table, figure["data"][0].get("dimensions", ()))

    @app.callback(
        Output("count", "children"),
        Output("table", "children"),
        Input("visible-rows", "data"),
        Input("order", "value"),
    )
    def list_visible_rows(visible_rows: list[int], order: str) -> tuple[str, Component]:
        rows = table.iloc[visible_rows].sort_values(order).head(MAX_ROWS)
        return f"{len(visible_rows):,} of {len(table):,} {explorer.noun}s", layout.build_table(
            format_cells(rows)
        )


def _add_front(app: Dash, explorer: Explorer) -> None:
    @app.callback(
        Output("front", "figure"),
        Input("x", "value"),
        Input("y", "value"),
        Input("visible-rows", "data"),
        Input("selected", "value"),
        Input("design-metrics", "data"),
    )
    def draw_front(
        x: str, y: str, visible_rows: list[int], selected: int, metrics: dict[str, float]
    ) -> go.Figure:
        return figures.draw_front(explorer.table, x, y, visible_rows, selected, metrics)

    @app.callback(
        Output("selected", "value"), Input("front", "clickData"), prevent_initial_call=True
    )
    def select_solution(click: dict[str, Any]) -> int:
        return int(click["points"][0]["customdata"])


def _add_design(app: Dash, explorer: Explorer) -> None:
    variables = {"variable": ALL}
    start = perf_counter()
    explorer.evaluate(explorer.X[explorer.default_position])
    is_fast = perf_counter() - start < MAX_EVALUATION_TIME

    @app.callback(
        Output(variables, "value"),
        Output(variables, "drag_value"),
        Input("selected", "value"),
        Input("undo", "n_clicks"),
    )
    def show_solution(selected: int, _: int | None) -> tuple[list[float], list[float]]:
        x = explorer.X[selected].tolist()
        return x, x

    @app.callback(
        Output("numbers", "children"),
        Output("constraints", "children"),
        Output("design-metrics", "data"),
        Input(variables, "drag_value" if is_fast else "value"),
        State("selected", "value"),
        prevent_initial_call=True,
    )
    def evaluate_design(
        x: list[float], selected: int
    ) -> tuple[Component, list[Component], dict[str, float]]:
        metrics, margins = explorer.evaluate(x)
        _show_message("")
        lines: list[Component] = [
            html.P(str(margin), className="" if margin.is_satisfied else "violated")
            for margin in margins
        ]
        solution = extract_row(explorer.table, selected)
        return layout.build_comparison(explorer.noun, solution, metrics), lines, metrics

    @app.callback(
        Output("figures", "children"), Input(variables, "value"), prevent_initial_call=True
    )
    def draw_figures(x: list[float]) -> list[Component]:
        figures_by_name = explorer.build_figures(x).items()
        return [
            layout.build_graph(name, figure=figure.update_layout(template="plotly_white"))
            for name, figure in figures_by_name
        ]

    @app.callback(
        Output("saved", "children"),
        Input("save", "n_clicks"),
        State(variables, "value"),
        State("file", "value"),
        prevent_initial_call=True,
    )
    def save_design(_: int, x: list[float], name: str) -> str:
        path = explorer.save(x, name)
        _show_message("")
        return f"written: {path}"


def _show_message(text: str) -> None:
    set_props("message", {"children": join_lines(text)})
