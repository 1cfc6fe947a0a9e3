"""The velocities of a question for damping: the own one, and others where damping is learned over several."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from incsvr.errors import BadInput
from incsvr.learning.model import Model
from incsvr.plant.words import AxisWords
from service.config.configuration import Config
from service.number import number_of
from service.wire import Numbers

MAX_RATES = 5_000
"""400 kB of answer."""
MAX_RATE = 1e3
"""Whoever asks for a velocity beyond [rad/s], [m/s] has another unit."""


@dataclass(frozen=True, slots=True)
class DampingQuery:
    """The velocities of a question. It holds plain numbers: most questions name one rate, and arrays cost more than all
    that is done with it.

    Attributes:
        rate: (n,) of the axis itself, n ≥ 1.
        others: further ones by name, each (n,) or a single value for all.
    """

    rate: Numbers
    others: Mapping[str, Numbers] = field(default_factory=dict)

    def columns(self, model: Model) -> list[Numbers]:
        """(n,) values of each velocity of a trained model, the own one first. Of several, one that is not named is as
        usual where it learned.

        Raises:
            BadInput: a name that the model does not know, or values of different number.
        """
        several = model.several
        known = () if several is None else several.others
        for name in self.others:
            if name not in known:
                over = ", ".join((several.own, *known)) if several is not None else "the own velocity alone"
                raise BadInput(f"{name[:80]}= is given, but damping is learned over {over}; leave it out")
        if several is None:
            return [self.rate]
        usual = dict(zip(known, several.usual.tolist(), strict=True))
        columns = [self.rate, *(self.others.get(name, (usual[name],)) for name in known)]
        most = max(len(column) for column in columns)
        if any(len(column) not in (1, most) for column in columns):
            sizes = ", ".join(f"{n} {len(c)}" for n, c in zip((several.own, *known), columns, strict=True))
            raise BadInput(f"give every velocity the same number of values, or one for all; there are of {sizes}")
        return [column if len(column) == most else column * most for column in columns]


def velocity_names(config: Config) -> dict[str, str]:
    """The names of a velocity in a question → `rate` for the own one, else the stream of a further one."""
    own, *further = config.learner.inputs
    if not further:
        return {"rate": "rate"}
    streams = dict(zip(further, config.further_inputs, strict=True))
    return {"rate": "rate", own: "rate"} | streams | {stream: stream for stream in streams.values()}


def checked_query(values: Sequence[tuple[str, Numbers]], words: AxisWords) -> DampingQuery:
    """A question with the values of `rate`, which the axis's words name, and of further velocities.

    Raises:
        BadInput: one is missing or given twice, there are too many, or one is no velocity of a vehicle.
    """
    found = dict(values)
    if len(found) < len(values):
        raise BadInput("a velocity is given under two names; give it once")
    if "rate" not in found:
        raise BadInput(f"give the own velocity as well, such as rate=0.1 beside {next(iter(found))}=")
    for name, each in values:
        if len(each) > MAX_RATES:
            raise BadInput(f"these are more than {MAX_RATES} values; ask in several queries")
        if not all(abs(value) <= MAX_RATE for value in each):
            what, unit = f"a {words.rate}", words.rate_unit
            if name != "rate":
                what, unit = f"a value of {name[:80]}", "its unit"
            raise BadInput(f"{what} is NaN, infinite or beyond {MAX_RATE:g} {unit}; ask for finite values in {unit}")
    return DampingQuery(found.pop("rate"), found)


def parse_numbers(name: str, text: str, unit: str) -> Numbers:
    """The numbers of a parameter in a unit, such as -0.2,0,0.2.

    Raises:
        BadInput: these are none.
    """
    if text.count(",") >= MAX_RATES:
        raise BadInput(f"these are more than {MAX_RATES} values; ask in several queries")
    try:
        return tuple(map(number_of, text.split(",")))
    except ValueError:
        if "&" in text:
            raise BadInput(f"{name}={text[:80]}: separate velocities by ;, as in rate=0.1;surge=0.5") from None
        raise BadInput(f"{name}={text[:80]} is no list of numbers; write them like -0.2,0,0.2 in {unit}") from None
