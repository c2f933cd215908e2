"""Settings: frozen pydantic dataclasses whose fields declare their meaning, unit and range.

A settings class represents one table of a file::

    from pydantic.dataclasses import dataclass

    @dataclass(frozen=True, kw_only=True)
    class Wheel(Settings):
        max_torque: Annotated[float, Unit("N m")] = Field(default=0.1, gt=0.0)
        "largest torque"

    Wheel(max_torque=-1)
    # InvalidValue: max_torque = -1: expected a number > 0 [N m] (largest torque)

The declarations generate the JSON Schema, the comments in scenario files and the reference pages of
keys.
"""
