"""What a bias follows beside itself: a temperature, a current, whatever a channel measures."""

from __future__ import annotations

from collections.abc import Callable, MutableMapping, Sequence
from dataclasses import dataclass
from typing import Any

from mgeo_attitude.fields import Validated, positive, quantity
from mgeo_attitude.fields.quantity import Unit

#: What the names of its states begin with.
PREFIX = "bias_per_"


@dataclass(frozen=True)
class Influence(Validated):
    """A bias that is larger by c (u - u₀) for a channel's value u; c is a constant of each axis.

    Examples
    --------
    >>> from mgeo_attitude import Gyro, Influence
    >>> list(Gyro(influences=(Influence("temp", 5e-4, "degC", 20.0),)).states())
    ['bias', 'bias_per_temp']
    """

    channel: str = quantity(
        doc="name of the channel: of one of the scenario's channels, in telemetry of a column"
    )
    initial_sigma: float = positive(
        doc="1-sigma of what a unit of the channel adds, per axis, in the unit of the initial "
        "bias: deg/s, nT, or of a unit vector"
    )
    unit: str = quantity("unit", doc="unit of the channel, for people")
    reference: float = quantity(0.0, doc="value of the channel at which the bias is the bias")

    @property
    def state(self) -> str:
        """Name of its state."""
        return f"{PREFIX}{self.channel}"

    def unit_of(self, bias: Unit) -> Unit:
        """Unit of the state, of a bias in that unit."""
        return Unit(f"{bias.text} per {self.unit}", bias.suffix, bias.factor)


def influenced(
    influences: Sequence[Influence],
    own: MutableMapping[str, Any],
    values: Sequence[Any],
    times: Callable[[Any, Any], Any] = lambda value, coefficient: value * coefficient,
) -> MutableMapping[str, Any]:
    """States of an owner with what channels make of its bias in that, and without their own.

    Parameters
    ----------
    own : mapping
        States by their names, which is changed.
    values : sequence
        u - u₀ of each, in a shape that goes with the states'.
    times : function
        Product of a value and a state.
    """
    for influence, value in zip(influences, values, strict=True):
        own["bias"] = own["bias"] + times(value, own.pop(influence.state))
    return own
