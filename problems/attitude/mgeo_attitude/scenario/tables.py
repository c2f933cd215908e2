"""Scenarios as nested tables: dicts and lists of plain values, as TOML and JSON have them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields
from datetime import datetime
from typing import Any, TypeVar

from ..fields import InvalidType, InvalidValue, Validated, declared, expectation
from ..sensors import SENSORS, Sensor
from .limits import KeepOut, Wheels
from .objective_names import PAPER
from .orbit import Orbit, TLEOrbit
from .presets import PRESETS
from .scenario import Scenario
from .suggestions import known_names

Table = Mapping[str, Any]
Section = TypeVar("Section", bound=Validated)


class KeyProblem(InvalidValue):
    """A key that is unknown, missing or given twice; its value is not at fault."""

    def __str__(self) -> str:
        return f"{self.key}: {self.expected}"


def to_table(scenario: Scenario) -> dict[str, Any]:
    """The scenario as nested dicts and lists; the epoch becomes an ISO 8601 string."""
    table = _plain_fields(scenario)
    if scenario.objectives == PAPER:  # they go without saying
        del table["objectives"]
    return table


def from_table(table: Table) -> Scenario:
    """Inverse of `to_table`; see `Scenario.from_dict`."""
    values = _on_preset(table)
    _check_keys(Scenario, values, "", selector="preset")
    for key, (annotation, _) in declared(Scenario).items():
        if key in values and isinstance(annotation, type) and issubclass(annotation, Validated):
            values[key] = _section(annotation, values[key], key)
    values["epoch"] = _epoch(values["epoch"])
    values["orbit"] = _orbit(values["orbit"])
    values["sensors"] = _sensors(values["sensors"])
    for key in ("trace_weights", "required_sigma"):
        values[key] = _flat(values.get(key, {}), key)
    if "wheels" in values:
        values["wheels"] = _section(Wheels, values["wheels"], "wheels")
    values["keep_outs"] = tuple(
        _section(KeepOut, table, f"keep_outs[{i}]")
        for i, table in enumerate(_list(values.get("keep_outs", ()), "keep_outs"))
    )
    return Scenario(**values)


def _plain_fields(section: Validated) -> dict[str, Any]:
    selector = {}
    if isinstance(section, Sensor):
        selector = {"kind": section.kind}
    elif isinstance(section, TLEOrbit):
        selector = {"propagator": section.propagator}
    values = {key: getattr(section, key) for key in declared(type(section))}
    # TOML has no word for nothing: what is not given is left out
    given = {key: value for key, value in values.items() if value is not None and value != ()}
    return selector | {key: _plain(value) for key, value in given.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, Validated):
        return _plain_fields(value)
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, datetime):
        return value.isoformat().replace("+00:00", "Z")
    return value


def _on_preset(table: Table) -> dict[str, Any]:
    if "preset" not in table:
        return dict(table)
    preset = table["preset"]
    if not isinstance(preset, str) or preset not in PRESETS:
        raise InvalidValue("preset", preset, f"unknown preset{known_names(preset, PRESETS)}")
    base = to_table(PRESETS[preset]())
    overrides = {key: value for key, value in table.items() if key != "preset"}
    orbit = overrides.get("orbit")
    if isinstance(orbit, Mapping) and orbit.get("propagator") == TLEOrbit.propagator:
        del base["orbit"]  # elements and element sets share no key
    sensors = overrides.get("sensors")
    if isinstance(sensors, list | tuple):
        overrides["sensors"] = [_on_sensor(entry, base["sensors"]) for entry in sensors]
    return _merged(base, overrides)


def _on_sensor(table: Any, preset: list[Table]) -> Any:
    """A sensor over the preset's one of its name and kind, or else the only one of its kind."""
    if not isinstance(table, Mapping):
        return table
    name, kind = table.get("name"), table.get("kind")
    same = [one for one in preset if one["name"] == name and kind in (None, one["kind"])]
    same = same or [one for one in preset if one["kind"] == kind]
    return {**same[0], **table} if len(same) == 1 else table


def _merged(base: Table, overrides: Table) -> dict[str, Any]:
    merged = dict(base)
    for key, value in overrides.items():
        nested = isinstance(value, Mapping) and isinstance(merged.get(key), Mapping)
        merged[key] = _merged(merged[key], value) if nested else value
    return merged


def _orbit(table: Any) -> Orbit | TLEOrbit:
    classes = {"two-body": Orbit, "j2": Orbit, TLEOrbit.propagator: TLEOrbit}
    orbit: Orbit | TLEOrbit = _selected(classes, table, "orbit", "propagator", "two-body")
    return orbit


def _sensors(tables: Any) -> tuple[Sensor, ...]:
    return tuple(
        _selected(SENSORS, table, f"sensors[{i}]", "kind")
        for i, table in enumerate(_list(tables, "sensors"))
    )


def _list(tables: Any, key: str) -> list[Any]:
    if not isinstance(tables, list | tuple):
        raise InvalidType(key, tables, "expected a list of tables")
    return list(tables)


def _selected(
    classes: Mapping[str, type[Any]], table: Any, key: str, selector: str, default: str = ""
) -> Any:
    """The section `key`, of the class that the entry `selector` of its table names."""
    _check_table(table, key)
    if not (selector in table or default):
        raise KeyProblem(f"{key}.{selector}", None, f"missing{known_names('', classes)}")
    name = table.get(selector, default)
    if not isinstance(name, str) or name not in classes:
        raise InvalidValue(
            f"{key}.{selector}", name, f"unknown {selector}{known_names(name, classes)}"
        )
    return _section(classes[name], table, key, selector)


def _section(cls: type[Section], table: Any, key: str, selector: str = "") -> Section:
    _check_table(table, key)
    _check_keys(cls, table, f"{key}.", selector)
    try:
        return cls(**{name: table[name] for name in declared(cls) if name in table})
    except InvalidValue as error:
        raise error.under(key) from None


def _check_table(value: Any, key: str) -> None:
    if not isinstance(value, Mapping):
        raise InvalidType(key, value, "expected a table")


def _check_keys(cls: type, table: Table, prefix: str, selector: str = "") -> None:
    declarations = declared(cls)
    selectors = {selector} - declarations.keys() - {""}
    known = [*selectors, *declarations]
    for key, value in table.items():
        if key not in known:
            raise KeyProblem(f"{prefix}{key}", value, f"unknown key{known_names(key, known)}")
    for field in fields(cls):
        required = field.default is MISSING and field.default_factory is MISSING
        if required and field.name not in table:
            expected = expectation(*declarations[field.name])
            raise KeyProblem(f"{prefix}{field.name}", None, f"missing; {expected}")


def _epoch(value: Any) -> datetime:
    if isinstance(value, datetime):
        return value
    expected = "expected a date and time with UTC offset, such as 2018-06-05T00:00:00Z"
    if not isinstance(value, str):
        raise InvalidType("epoch", value, expected)
    try:
        return datetime.fromisoformat(value)
    except ValueError:
        raise InvalidValue("epoch", value, expected) from None


def _flat(weights: Any, key: str) -> dict[str, Any]:
    """Weights by state block, from keys ``"mag.bias"`` and from tables ``mag = {bias = 1}``."""
    _check_table(weights, key)
    flat: dict[str, Any] = {}
    for name, value in weights.items():
        nested = _flat(value, f"{key}.{name}") if isinstance(value, Mapping) else {"": value}
        for rest, weight in nested.items():
            block = f"{name}.{rest}" if rest else name
            if block in flat:
                raise KeyProblem(f"{key}.{block}", weight, "given twice")
            flat[block] = weight
    return flat
