"""What the figures of plans share, besides what all figures do."""

from __future__ import annotations

from typing import Any

from mgeo.figures.style import COLORS

# Gaps are short, so that a steep line is not taken for a gap in the data.
_DASHES = ("solid", "9px,3px", "3px,3px", "12px,3px,3px,3px", "18px,3px", "6px,3px,3px,3px")


def line(index: int, width: float = 2) -> dict[str, Any]:
    """Color and dash of one of several lines."""
    color, dash = COLORS[index % len(COLORS)], _DASHES[index % len(_DASHES)]
    return {"color": color, "dash": dash, "width": width}


def panels_height(rows: int) -> int:
    """Height [px] of a figure with so many rows of panels."""
    return 220 + 230 * rows


def title(text: str) -> dict[str, Any]:
    """The title of one of many small figures."""
    return {
        "text": text,
        "x": 0.02,
        "xanchor": "left",
        "y": 1.0,
        "yref": "container",
        "yanchor": "top",
        "pad": {"t": 9},
        "font": {"size": 15},
    }
