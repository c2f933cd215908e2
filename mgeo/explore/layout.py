"""HTML layout of the page of the explorer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from dash import dcc, html
from dash.development.base_component import Component

from mgeo.explore.explorer import Explorer, extract_row
from mgeo.plugins.review import find_column_kinds

N_INITIAL_AXES = 8  # initial number of parallel coordinates


def build_page(explorer: Explorer) -> Component:
    """Build the explorer page with controls, tables and empty figures."""
    columns = list(explorer.table.columns)
    solutions = [
        {"label": f"{explorer.noun} {row}", "value": position}
        for position, row in enumerate(explorer.rows.tolist())
    ]
    filters = build_section(
        "Filter",
        build_hint("Drag along an axis to select a range. Click on the axis to remove the range."),
        dcc.Dropdown(columns, columns[:N_INITIAL_AXES], id="axes", multi=True),
        html.Div(build_graph("parallel"), className="wide"),
        html.P(id="count"),
    )
    front = build_section(
        "Front",
        build_hint(
            f"Click on a point to select its {explorer.noun}. The star is the design of the "
            "sliders."
        ),
        build_labeled_control("x axis", build_dropdown("x", columns, columns[0])),
        build_labeled_control(
            "y axis", build_dropdown("y", columns, columns[min(1, len(columns) - 1)])
        ),
        build_graph("front"),
    )
    undo, save = html.Button("Undo changes", id="undo"), html.Button("Save", id="save")
    file = dcc.Input(explorer.file_name, id="file")
    design = build_section(
        "Design",
        build_toolbar(build_dropdown("selected", solutions, explorer.default_position), undo),
        *build_sliders(explorer),
        build_toolbar(file, save, html.Output(id="saved")),
    )
    prediction = build_section("Prediction", html.Div(id="numbers"), html.Div(id="constraints"))
    order = build_labeled_control("sorted by", build_dropdown("order", columns, columns[0]))
    first = extract_row(explorer.table, explorer.default_position)
    return html.Main(
        [
            html.H1(explorer.title),
            html.P(id="message", role="alert"),
            filters,
            html.Div([front, design, prediction], className="columns"),
            build_section("Figures of the design", html.Div(id="figures", className="figures")),
            build_section(
                f"{explorer.noun.capitalize()}s", order, html.Div(id="table", className="wide")
            ),
            dcc.Store(id="visible-rows", data=list(range(len(explorer.X)))),
            dcc.Store(id="design-metrics", data=first),
        ]
    )


def build_section(title: str, *parts: Component) -> Component:
    return html.Section([html.H2(title), *parts])


def build_hint(text: str) -> Component:
    return html.P(text, className="hint")


def build_toolbar(*parts: Component) -> Component:
    return html.Div(parts, className="bar")


def build_labeled_control(text: str, control: Component) -> Component:
    return html.Label([html.Span(text), control], className="labeled")


def build_dropdown(name: str, options: Sequence[Any], value: Any) -> Component:
    return dcc.Dropdown(options, value, id=name, clearable=False)


def build_graph(name: str, **properties: Any) -> Component:
    """Create an empty Dash graph whose ID is `name`."""
    # The button that uploads the figure is removed, so that data do not leave this machine.
    config: Any = {"displaylogo": False, "showSendToCloud": False}
    return dcc.Graph(id=name, config=config, **properties)


def build_sliders(explorer: Explorer) -> Iterator[Component]:
    """Yield a labeled slider for each design variable.

    The slider of a categorical variable has the options of the variable as marks.
    """
    variables = explorer.variables
    columns = zip(explorer.names, variables.kinds, variables.xl, variables.xu, strict=True)
    for j, (name, kind, low, high) in enumerate(columns):
        marks = {i: str(option) for i, option in enumerate(variables.options.get(name, ()))}
        step = (high - low) / 1000 if kind == "real" else 1
        slider = dcc.Slider(low, high, step, marks=marks or None, id={"variable": j})
        yield html.Div([html.Label(name), slider], className="variable")


def build_table(rows: Sequence[Sequence[str]]) -> Component:
    """Return an HTML table of strings, with the first row as the header."""
    kinds = find_column_kinds(rows)
    head, *body = (
        html.Tr([html.Td(text, className=kind) for text, kind in zip(row, kinds, strict=True)])
        for row in rows
    )
    return html.Table([html.Thead(head), html.Tbody(body)])


def build_comparison(
    noun: str, solution: Mapping[str, float], design_metrics: Mapping[str, float]
) -> Component:
    """Build an HTML table that compares a solution with a modified design.

    `noun` is the word for a solution.
    """
    rows = [["", noun, "design", "change"]]
    for name, value in solution.items():
        new_value = design_metrics[name]
        change = f"{100 * (new_value / value - 1):+.3g} %" if value else ""
        rows.append([name, f"{value:.5g}", f"{new_value:.5g}", change])
    return build_table(rows)
