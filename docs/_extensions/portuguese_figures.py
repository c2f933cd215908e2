"""Figures of the pages in Portuguese: figures of ``docs/concepts.md`` with translated texts."""

from collections.abc import Callable

import concept_figures
import plotly.graph_objects as go

_TEXTS = {
    "attitude, at rest": "atitude, em repouso",
    "attitude, rotating about x, y, z": "atitude, girando em torno de x, y, z",
    "magnetometer misalignment, at rest": "desalinhamento do magnetômetro, em repouso",
    "magnetometer misalignment, rotating about x, y, z": (
        "desalinhamento do magnetômetro, girando em torno de x, y, z"
    ),
    "1-sigma of the worst axis [deg]": "1 sigma do pior eixo [graus]",
    "time [s]": "tempo [s]",
    "t_end by the rule end": "t_end pela regra end",
    "t_end by the rule trace": "t_end pela regra trace",
    "trace of the covariance [-]": "traço da covariância [-]",
    "plans": "planos",
    "lower bound": "limitante inferior",
    "time until the end of the plan, t_end [s]": "tempo até o fim do plano, t_end [s]",
    "τ = 0": "τ = 0",
    "τ = 1": "τ = 1",
    "τ = 3": "τ = 3",
    "probability": "probabilidade",
    "rank of the candidate": "posição do candidato na ordem",
    "hypervolume": "hipervolume",
    "front": "frente",
    "reference point": "ponto de referência",
    "first objective, scaled": "primeiro objetivo, normalizado",
    "second objective, scaled": "segundo objetivo, normalizado",
}


def translate(figure: go.Figure) -> go.Figure:
    """Translate names and axis titles of a figure in place, and write decimal commas.

    Raises
    ------
    KeyError
        If a text has no translation.
    """
    for part in figure.data:
        if part.name is not None:
            part.name = _TEXTS[part.name]
    for axis in (figure.layout.xaxis, figure.layout.yaxis):
        axis.title.text = _TEXTS[axis.title.text]
    return figure.update_layout(separators=",.")


def _build_translated(build: Callable[[], go.Figure]) -> Callable[[], go.Figure]:
    return lambda: translate(build())


FIGURES: dict[str, Callable[[], go.Figure]] = {
    f"{name}-pt": _build_translated(build) for name, build in concept_figures.FIGURES.items()
}
