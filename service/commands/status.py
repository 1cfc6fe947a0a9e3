"""`incsvr status`: one screen of what a running learner hears and makes of it; exit status 0 where health is OK.

With `--follow` the screen is live, with a line for each iteration, until Ctrl-C. Where the output is no terminal, the
lines alone: each iteration, and whenever health changes its level or learning its state.
"""

from __future__ import annotations

import argparse
import io
import logging
import math
import queue
import sys
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from rich.console import Group, RenderableType
from rich.live import Live

from incsvr.errors import BadInput
from incsvr.numerics.plain import to_plain
from incsvr.plant.axes import AXES, YAW, Axis
from service.bus.client import Client, NoAnswer, bus_client
from service.bus.session import stop_event
from service.cli.display import AxisState, Console, screen, vehicle_screen
from service.cli.output import WIDTH, add_json_argument, emit, iteration_line, learning_line
from service.config.configuration import Config
from service.config.sources import add_config_arguments, from_arguments
from service.wire import Form, Health, IterationReport, Keys, ModelSnapshot, decode

log = logging.getLogger(__name__)

AWAY_AFTER_S = 3.0
"""Health comes once a second; without any for so long [s], the learner is away."""
NO_AXES: Mapping[str, AxisState] = {}
"""A learner that is the only one of its vehicle."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--follow", action="store_true", help="show it live, and one line per iteration, until Ctrl-C")
    parser.add_argument("--wait", type=float, help="how long to try [s] (default 3; with --follow until Ctrl-C)")
    add_config_arguments(parser)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    config = from_arguments(args)
    if args.follow:
        if args.json is not None:
            raise BadInput("--follow shows a screen; leave out --json, or ask for it without --follow")
        return _follow(config, math.inf if args.wait is None else args.wait)
    with bus_client(config, AWAY_AFTER_S if args.wait is None else args.wait) as client:
        health, model = look(client)
        axes = look_at_axes(client, health)
    result = _plain(AxisState(health, model))
    if axes:
        result["axes"] = {axis: _plain(state) for axis, state in axes.items()}
    stream = sys.stderr if args.json == "-" else sys.stdout
    drawn = text(config.prefix, health, model, stream.isatty(), config.axis_asked, axes)
    emit(args, result, drawn, drawn=True)
    levels = [health.level, *(state.health.level for state in axes.values())]
    return 0 if set(levels) == {"OK"} else 1


def look(client: Client) -> tuple[Health, ModelSnapshot | None]:
    """Health, and the model where there is one.

    Raises:
        NoAnswer: nobody answers in time.
    """
    health = client.ask(client.keys.health, Health)
    return health, client.ask_if_any(client.keys.model, ModelSnapshot)


def look_at_axes(client: Client, health: Health) -> dict[str, AxisState]:
    """The answers of the learners of all axes of the vehicle, if the process learns several.

    Raises:
        NoAnswer: nobody answers in time.
    """
    return {axis: AxisState(*look(replace(client, keys=Keys(prefix)))) for axis, prefix in health.axes.items()}


def text(
    prefix: str,
    health: Health,
    model: ModelSnapshot | None,
    colours: bool = False,
    axis: Axis = YAW,
    axes: Mapping[str, AxisState] = NO_AXES,
) -> str:
    """The screen as text; above it a line for each axis of the vehicle, where several are learned."""
    console = Console(file=io.StringIO(), width=WIDTH, force_terminal=colours, no_color=not colours, highlight=False)
    with console.capture() as capture:
        if axes:
            console.print(vehicle_screen(health.vehicle, axes), "")
        console.print(screen(prefix, health, model, axis))
    return "\n".join(line.rstrip() for line in capture.get().splitlines())


def _plain(state: AxisState) -> dict[str, Any]:
    """The value as JSON writes it."""
    model = state.model
    return {
        "health": to_plain(state.health),
        "model": None if model is None else to_plain(model),
    }


def _follow(config: Config, wait: float) -> int:
    stop = stop_event()
    logging.basicConfig(level=logging.INFO, stream=sys.stderr, format="incsvr status: %(message)s")
    try:
        with bus_client(config, wait, stop) as client:
            console = Console(width=None if sys.stdout.isatty() else WIDTH, highlight=False)
            follow(client, console, stop, config.axis_asked)
    except (BadInput, NoAnswer):
        if not stop.is_set():  # a signal while it waited is no failure
            raise
    return 0


def follow(client: Client, console: Console, stop: threading.Event, axis: Axis = YAW) -> None:
    """Shows what comes until `stop` is set, in the words and units of the axis; of a vehicle whose axes are learned
    together, a line for each axis above.

    Raises:
        NoAnswer: no learner answers at the beginning.
    """
    own = client.keys.prefix
    came: queue.Queue[tuple[str, Form]] = queue.Queue()
    subscribers = _subscribe(client, client.keys, came)
    health, model = _first_look(client)
    axes = {prefix: AXES[name] for name, prefix in health.axes.items()} or {own: axis}
    states = {own: AxisState(health, model)}
    for prefix in axes.keys() - {own}:
        keys = Keys(prefix)
        subscribers += _subscribe(client, keys, came)
        states[prefix] = AxisState(*look(replace(client, keys=keys)))
    changes = {prefix: _Says(console, prefix, each.name if len(axes) > 1 else "") for prefix, each in axes.items()}
    for prefix, say in changes.items():
        say.health(states[prefix].health)

    def shown() -> RenderableType:
        detail = screen(own, states[own].health, states[own].model, axis)
        if len(axes) == 1:
            return detail
        return Group(vehicle_screen(health.vehicle, {each.name: states[k] for k, each in axes.items()}), "", detail)

    with Live(shown(), console=console, auto_refresh=False) as live:
        waited = 0.0
        while not stop.is_set():
            try:
                prefix, form = came.get(timeout=0.5)
            except queue.Empty:
                waited += 0.5
                if waited >= AWAY_AFTER_S:
                    changes[own].away()
                continue
            waited = 0.0
            if isinstance(form, IterationReport):
                changes[prefix].print(iteration_line(form, axes[prefix]))
            elif isinstance(form, ModelSnapshot):
                states[prefix] = replace(states[prefix], model=form)
            elif isinstance(form, Health):
                states[prefix] = replace(states[prefix], health=form)
                changes[prefix].health(form)
            if console.is_terminal:
                live.update(shown(), refresh=True)
        if not console.is_terminal:
            live.update("")
    for subscriber in subscribers:
        subscriber.undeclare()


def _subscribe(client: Client, keys: Keys, came: queue.Queue[tuple[str, Form]]) -> list[Any]:
    """Puts what a learner publishes into the queue, with the prefix of its keys."""
    forms: dict[str, type[Form]] = {keys.health: Health, keys.model: ModelSnapshot, keys.iteration: IterationReport}
    return [client.session.declare_subscriber(key, _put(form, keys.prefix, came)) for key, form in forms.items()]


def _first_look(client: Client) -> tuple[Health, ModelSnapshot | None]:
    """The learner's first answer; the wait for it is reported."""
    soon = min(client.until, time.monotonic() + AWAY_AFTER_S)
    try:
        return look(replace(client, until=soon))
    except NoAnswer as error:
        if client.stop.is_set() or soon == client.until:
            raise
        log.info("waiting for the learner: %s", error)
        return look(client)


class _Says:
    """A line whenever the level or the state changes, and for each iteration; `axis` begins it where there are more."""

    def __init__(self, console: Console, prefix: str, axis: str = "") -> None:
        self._console, self._prefix, self._axis = console, prefix, axis
        self._said: tuple[str, ...] = ()

    def print(self, line: str) -> None:
        self._console.print(f"{self._axis}: {line}" if self._axis else line, soft_wrap=True)

    def health(self, health: Health) -> None:
        now = (health.level, health.learning.state)
        if now == self._said:
            return
        if self._said[1:] != now[1:]:
            self.print(learning_line(health.learning))
        if self._said[:1] != now[:1]:
            why = "" if not health.reasons else f": {health.reasons[0]}"
            self.print(f"health is {health.level}{why}")
        self._said = now

    def away(self) -> None:
        if self._said != ("away",):
            self._console.print(f"the learner of {self._prefix} does not answer; waiting for it", soft_wrap=True)
            self._said = ("away",)


def _put(form: type[Form], prefix: str, came: queue.Queue[tuple[str, Form]]) -> Callable[[Any], None]:
    def take(sample: Any) -> None:
        try:
            came.put((prefix, decode(form, sample.payload.to_bytes())))
        except BadInput:
            return  # another program publishes on this key

    return take
