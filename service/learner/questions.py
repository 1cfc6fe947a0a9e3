"""The checked parameters and payload of a query to the learner."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
import zenoh

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.words import AxisWords
from service import wire
from service.learner.damping_query import DampingQuery, checked_query, parse_numbers
from service.number import number_of, whole_number_of

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
    payload = wire.decode(wire.DampingQuery, query.payload.to_bytes())
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
