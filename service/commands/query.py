"""`incsvr query`: asks a running learner for the damping at some yaw rates."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping, Sequence

from incsvr.errors import BadInput
from incsvr.learning.coefficients import NORMAL_95_DEVIATIONS
from incsvr.numerics.plain import to_plain
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.words import words_of
from service.bus.client import bus_client
from service.cli.output import emit
from service.commands.arguments import add_question_arguments
from service.config.configuration import Config
from service.config.sources import from_arguments
from service.number import number_of
from service.wire import DampingReply, ModelSnapshot


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "rates",
        metavar="RATE",
        nargs="+",
        help="yaw rates [rad/s]; further velocities of the damping as NAME=VALUE, such as surge=0.5",
    )
    add_question_arguments(parser)


def run(args: argparse.Namespace) -> int:
    config = from_arguments(args)
    axis = config.axis_asked
    reply, learned = ask(config, *velocities(args.rates, axis), args.wait)
    first = not_learned(reply, learned, axis)
    emit(args, to_plain(reply), "\n".join([*([first] if first else []), table(reply, axis)]))
    return 0


HEADS = {
    "damping": ("damping [{effort_unit}]", 13, 1.0),
    "doubt": ("± (95 %) [{effort_unit}]", 13, NORMAL_95_DEVIATIONS),
    "sigma": ("samples ± (95 %) [{effort_unit}]", 13, NORMAL_95_DEVIATIONS),
    "derivative": ("derivative [{linear_unit}]", 22, 1.0),
}
"""By field: the head of its column, a template of `AxisWords`; its least width in characters; the factor of its values.
An older learner does not give all."""


def velocities(given: Sequence[str], axis: Axis = YAW) -> tuple[list[float], dict[str, list[float]]]:
    """The own velocities of a command line, and further ones by name.

    Raises:
        BadInput: a word is no finite number and names none.
    """
    words, rates = words_of(axis), list[float]()
    others: dict[str, list[float]] = {}
    for word in given:
        name, equals, text = word.rpartition("=")
        own = not equals or name in ("rate", axis.rate)
        for part in text.split(","):
            try:
                value = number_of(part)
            except ValueError:
                value = math.nan
            if not math.isfinite(value):
                what = words.rate if own else f"value of channel {name}"
                unit = f" in {words.rate_unit}" if own else ""
                raise BadInput(f"{part} is no {what}; give finite numbers{unit}")
            (rates if own else others.setdefault(name, [])).append(value)
    if not rates:
        raise BadInput(f"give a {words.rate} beside {next(iter(others))}, such as 0.1 in {words.rate_unit}")
    return rates, others


def ask(
    config: Config, rates: list[float], others: Mapping[str, list[float]], patience_s: float
) -> tuple[DampingReply, tuple[float, float] | None]:
    """The learner's answer, and the range that it learned where the answer reaches beyond it; asked again while it
    restarts.

    Args:
        others: further velocities by name, each one value or as many as there are rates.

    Raises:
        NoAnswer: nobody answers within the time, or nothing has been learned until then.
        BadInput: the learner refuses the question.
    """
    with bus_client(config, patience_s) as client:
        named = {"rate": rates, **others}
        asked = ";".join(f"{name}={','.join(map(repr, values))}" for name, values in named.items())
        reply = client.ask(f"{client.keys.damping}?{asked}", DampingReply)
        model = client.ask_if_any(client.keys.model, ModelSnapshot) if any(reply.extrapolated) else None
        return reply, None if model is None else model.model.trained_range


def not_learned(reply: DampingReply, learned: tuple[float, float] | None, axis: Axis = YAW) -> str | None:
    """The remark on rates beyond the learned range [rad/s]; None if all are within."""
    foreign = [rate for rate, beyond in zip(reply.rate, reply.extrapolated, strict=True) if beyond]
    if not foreign:
        return None
    known, unit = "", words_of(axis).rate_unit
    if learned is not None:
        low, high = learned
        over, under = max(foreign) > high, min(foreign) < low
        ends = f"up to {high:.3g}" if over and not under else f"down to {low:.3g}" if under and not over else ""
        known = f" ({ends or f'{low:.3g} to {high:.3g}'} {unit}"
        inside = "" if over or under else ", with gaps" if not reply.others else ", among other velocities"
        known = f"{known}{inside})"
    some = "" if len(foreign) == len(reply.rate) else f": {', '.join(f'{rate:g}' for rate in foreign)} {unit}"
    return f"not learned there{known}{some}"


def table(reply: DampingReply, axis: Axis = YAW) -> str:
    """The answer for people."""
    asked = {"{rate} [{rate_unit}]": reply.rate, **reply.others}
    columns = [(head, 16, [f"{each:.4f}" for each in values]) for head, values in asked.items()]
    for name, (head, width, factor) in HEADS.items():
        if values := getattr(reply, name):
            columns.append((head, width, [f"{factor * each:.2f}" for each in values]))
    aligned = []
    for template, width, texts in columns:
        head = words_of(axis).fill(template)
        aligned.append([f"{text:>{max(width, len(head))}s}" for text in (head, *texts)])
    notes = ("", *("   extrapolated" if each else "" for each in reply.extrapolated))
    lines = ["   ".join(cells) + note for *cells, note in zip(*aligned, notes, strict=True)]
    return "\n".join([*lines, f"iteration {reply.iteration}, revision {reply.revision}"])
