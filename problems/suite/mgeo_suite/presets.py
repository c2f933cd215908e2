"""Options to start from, by name."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

#: Objectives of each preset; all have the scenario of ``cubesat.toml``.
PRESETS: Mapping[str, tuple[str, ...]] = {
    "cubesat": ("price", "attitude"),
    "cubesat_time": ("price", "attitude", "t_end"),
}


def scenario_table() -> dict[str, Any]:
    """The scenario of the presets, as `Scenario.from_dict` takes it."""
    text = Path(__file__).with_name("cubesat.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)
