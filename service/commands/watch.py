"""`incsvr watch`: the screen of `incsvr status`, live, and a line for each iteration, until Ctrl-C.

Where the output is no terminal, the lines alone: each iteration, and whenever health changes its level or learning
its state.
"""

from __future__ import annotations

import argparse
import logging
import math
import queue
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from rich.console import Console
from rich.live import Live

from incsvr.errors import BadInput
from incsvr.plant.axes import AXES, YAW, Axis
from service.bus.client import Client, NoAnswer, bus_client
from service.bus.session import stop_event
from service.cli.display import screen
from service.cli.log_lines import iteration_line, learning_line
from service.cli.output import WIDTH
from service.commands.status import look
from service.config.sources import add_config_arguments, from_arguments
from service.wire import Form, Health, IterationReport, ModelSnapshot, decode

log = logging.getLogger(__name__)

AWAY_AFTER_S = 3.0
"""Health comes once a second; without any for so long [s], the learner is away."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--wait",
        type=float,
        default=math.inf,
        help="how long to wait for a bus and a learner [s] (default: until Ctrl-C)",
    )
    add_config_arguments(parser)


def run(args: argparse.Namespace) -> int:
    config = from_arguments(args)
    stop, axis = stop_event(), AXES[config.vehicle.axis]
    logging.basicConfig(level=logging.INFO, stream=sys.stderr, format="incsvr watch: %(message)s")
    try:
        with bus_client(config, args.wait, stop) as client:
            follow(client, Console(width=None if sys.stdout.isatty() else WIDTH, highlight=False), stop, axis)
    except (BadInput, NoAnswer):
        if not stop.is_set():  # told to stop while it waited: that is no failure
            raise
    return 0


def follow(client: Client, console: Console, stop: threading.Event, axis: Axis = YAW) -> None:
    """Shows what comes until `stop` is set, in the words and units of the axis.

    Raises:
        NoAnswer: no learner answers at the beginning.
    """
    keys = client.keys
    forms: dict[str, type[Form]] = {keys.health: Health, keys.model: ModelSnapshot, keys.iteration: IterationReport}
    came: queue.Queue[Form] = queue.Queue()
    subscribers: list[Any] = [client.session.declare_subscriber(key, _put(form, came)) for key, form in forms.items()]
    health, model = _first_look(client)
    say = _Says(console, keys.prefix)
    say.health(health)
    with Live(screen(keys.prefix, health, model, axis), console=console, auto_refresh=False) as live:
        waited = 0.0
        while not stop.is_set():
            try:
                form = came.get(timeout=0.5)
            except queue.Empty:
                waited += 0.5
                if waited >= AWAY_AFTER_S:
                    say.away()
                continue
            waited = 0.0
            if isinstance(form, IterationReport):
                console.print(iteration_line(form, axis), soft_wrap=True)
            elif isinstance(form, ModelSnapshot):
                model = form
            elif isinstance(form, Health):
                health = form
                say.health(health)
            if console.is_terminal:
                live.update(screen(keys.prefix, health, model, axis), refresh=True)
        if not console.is_terminal:
            live.update("")
    for subscriber in subscribers:
        subscriber.undeclare()


def _first_look(client: Client) -> tuple[Health, ModelSnapshot | None]:
    """What the learner answers, once it does; that it is waited for is said."""
    soon = min(client.until, time.monotonic() + AWAY_AFTER_S)
    try:
        return look(replace(client, until=soon))
    except NoAnswer as error:
        if client.stop.is_set() or soon == client.until:
            raise
        log.info("waiting for the learner: %s", error)
        return look(client)


class _Says:
    """A line whenever the level or the state changes."""

    def __init__(self, console: Console, prefix: str) -> None:
        self._console, self._prefix = console, prefix
        self._said: tuple[str, ...] = ()

    def health(self, health: Health) -> None:
        now = (health.level, health.learning.state)
        if now == self._said:
            return
        if self._said[1:] != now[1:]:
            self._console.print(learning_line(health.learning), soft_wrap=True)
        if self._said[:1] != now[:1]:
            why = "" if not health.reasons else f": {health.reasons[0]}"
            self._console.print(f"health is {health.level}{why}", soft_wrap=True)
        self._said = now

    def away(self) -> None:
        if self._said != ("away",):
            self._console.print(f"the learner of {self._prefix} does not answer; waiting for it", soft_wrap=True)
            self._said = ("away",)


def _put(form: type[Form], came: queue.Queue[Form]) -> Callable[[Any], None]:
    def take(sample: Any) -> None:
        try:
            came.put(decode(form, sample.payload.to_bytes()))
        except BadInput:
            return  # another program publishes on this key

    return take
