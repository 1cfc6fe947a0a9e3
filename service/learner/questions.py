"""The checked parameters and payload of a query to the learner, and the velocities of a question for damping."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import zenoh

from incsvr.errors import BadInput
from incsvr.learning.model import Model
from incsvr.numerics import Array
from incsvr.plant.words import AxisWords
from service import wire
from service.config.configuration import Config
from service.number import number_of, whole_number_of
from service.wire import DampingQuery, Numbers

MAX_QUESTION_BYTES = 250_000
"""The longest payload of a question that is read."""


def effect_name(query: zenoh.Query) -> str:
    """The effect that an operator decides on."""
    name = parameters(query, "effect").get("effect")
    if not name:
        raise BadInput("name the effect, such as ?effect=torque_lag")
    return name


def parameters(query: zenoh.Query, *allowed: str) -> dict[str, str]:
    """The parameters of a question; what begins with an underscore is Zenoh's own.

    Raises:
        BadInput: there is one that nobody would heed.
    """
    given: Iterable[tuple[str, str]] = query.parameters  # type: ignore[assignment]  # its stubs lack __iter__
    pairs = [(name, value) for name, value in given if name and not name.startswith("_")]
    found = dict(pairs)
    if len(found) < len(pairs):
        raise BadInput("a parameter is given twice, and only one of them could be answered; ask in two queries")
    for name in found:
        if name not in allowed:
            may = f"ask with {', '.join(allowed)}" if allowed else "ask without parameters"
            raise BadInput(f"{name[:80]}= is no parameter of {query.key_expr}; {may}")
    return found


def damping_query(
    query: zenoh.Query, asked: Mapping[str, str], velocities: Mapping[str, str], words: AxisWords
) -> DampingQuery:
    """The velocities that are asked for, from the parameters or from the payload.

    Args:
        asked: the parameters of the question.
        velocities: what each may be called → `rate` for the own one, else the stream of a further one.
        words: of the axis.
    """
    given = {name: asked[name] for name in velocities if name in asked}
    if given:
        if query.payload is not None and len(query.payload):
            raise BadInput(f"ask for the {words.rates} either by rate= or in the payload, not for both")
        units = {name: words.rate_unit if velocities[name] == "rate" else "its unit" for name in given}
        numbers = [(velocities[name], parse_numbers(name, text, units[name])) for name, text in given.items()]
        return checked_query(numbers, words)
    if query.payload is None:
        raise BadInput(f"name the {words.rates} to answer for, such as ?rate=-0.2,0,0.2 in {words.rate_unit}")
    if len(query.payload) > MAX_QUESTION_BYTES:
        raise BadInput(f"the payload is longer than {MAX_QUESTION_BYTES} bytes; ask in several queries")
    payload = wire.decode(DampingQuery, query.payload.to_bytes())
    others = [(velocities.get(name, name), values) for name, values in payload.others.items()]
    return checked_query([("rate", payload.rate), *others], words)


def profile(query: zenoh.Query) -> bytes | None:
    """The payload of a question that plans something; None where it has none.

    Raises:
        BadInput: it is too long, or a parameter is given.
    """
    parameters(query)
    if query.payload is None or not len(query.payload):
        return None
    if len(query.payload) > MAX_QUESTION_BYTES:
        raise BadInput(f"the payload is longer than {MAX_QUESTION_BYTES} bytes; ask for fewer times")
    return query.payload.to_bytes()


def refuse_effort(effort: Array, limit: float, words: AxisWords) -> None:
    """Refuses a plan with an effort (n,) [N m] beyond the plausible `limit`, whether it is asked or what it takes."""
    if not np.abs(effort).max() <= limit:
        raise BadInput(
            f"a {words.effort} of {effort[np.abs(effort).argmax()]:g} {words.effort_unit} is planned; plan within "
            f"the plausible ±{limit:g} {words.effort_unit} (vehicle.torque_limit)"
        )


def number(name: str, text: str) -> float:
    """The finite number that a parameter is.

    Raises:
        BadInput: it is none.
    """
    try:
        value = number_of(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise BadInput(f"{name}={text[:80]} is no finite number")
    return value


def whole_number(name: str, text: str | None, most: int) -> int:
    """The whole number from 0 to `most` that a parameter is.

    Raises:
        BadInput: it is none.
    """
    try:
        value = whole_number_of(text or "")
    except ValueError:
        value = -1
    if not 0 <= value <= most:
        raise BadInput(f"{name}={(text or '')[:80]} is no whole number from 0 to {most}")
    return value


MAX_RATES = 5_000
"""400 kB of answer."""
MAX_RATE = 1e3
"""Whoever asks for a velocity beyond [rad/s], [m/s] has another unit."""


def columns(asked: DampingQuery, model: Model) -> list[Numbers]:
    """(n,) values of each velocity of a trained model, the own one first. Of several, one that is not named is as
    usual where it learned.

    They are plain numbers: most questions name one rate, and arrays cost more than all that is done with it.

    Raises:
        BadInput: a name that the model does not know, or values of different number.
    """
    several = model.several
    known = () if several is None else several.others
    for name in asked.others:
        if name not in known:
            over = ", ".join((several.own, *known)) if several is not None else "the own velocity alone"
            raise BadInput(f"{name[:80]}= is given, but damping is learned over {over}; leave it out")
    if several is None:
        return [asked.rate]
    usual = dict(zip(known, several.usual.tolist(), strict=True))
    found = [asked.rate, *(asked.others.get(name, (usual[name],)) for name in known)]
    most = max(len(column) for column in found)
    if any(len(column) not in (1, most) for column in found):
        sizes = ", ".join(f"{n} {len(c)}" for n, c in zip((several.own, *known), found, strict=True))
        raise BadInput(f"give every velocity the same number of values, or one for all; there are of {sizes}")
    return [column if len(column) == most else column * most for column in found]


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
    return DampingQuery(rate=found.pop("rate"), others=found)


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
