"""`incsvr status`: one screen of what a running learner hears and makes of it; exit status 0 where health is OK."""

from __future__ import annotations

import argparse
import io
import sys

from rich.console import Console

from incsvr.plant.axes import AXES, YAW, Axis
from service.bus.client import Client, bus_client
from service.cli.display import screen
from service.cli.output import WIDTH, emit
from service.commands.arguments import add_question_arguments
from service.config.sources import from_arguments
from service.wire import Health, ModelSnapshot


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_question_arguments(parser, wait_s=3.0)


def run(args: argparse.Namespace) -> int:
    config = from_arguments(args)
    with bus_client(config, args.wait) as client:
        health, model = look(client)
    result = {
        "health": health.model_dump(mode="json"),
        "model": None if model is None else model.model_dump(mode="json"),
    }
    stream = sys.stderr if args.json == "-" else sys.stdout
    emit(args, result, text(config.prefix, health, model, stream.isatty(), AXES[config.vehicle.axis]))
    return 0 if health.level == "OK" else 1


def look(client: Client) -> tuple[Health, ModelSnapshot | None]:
    """Health, and the model where there is one.

    Raises:
        NoAnswer: nobody answers in time.
    """
    health = client.ask(client.keys.health, Health)
    return health, client.ask_if_any(client.keys.model, ModelSnapshot)


def text(prefix: str, health: Health, model: ModelSnapshot | None, colours: bool = False, axis: Axis = YAW) -> str:
    """The screen as text."""
    console = Console(file=io.StringIO(), width=WIDTH, force_terminal=colours, no_color=not colours, highlight=False)
    with console.capture() as capture:
        console.print(screen(prefix, health, model, axis))
    return "\n".join(line.rstrip() for line in capture.get().splitlines())
