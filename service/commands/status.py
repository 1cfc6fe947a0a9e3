"""`incsvr status`: one screen of what a running learner hears and makes of it; exit status 0 where health is OK."""

from __future__ import annotations

import argparse
import io
import sys

from rich.console import Console

from incsvr.plant.axes import AXES, YAW, Axis
from service.bus.client import Client, NoAnswer, reaching
from service.cli.display import WIDTH, screen
from service.cli.output import add_json_argument, emit
from service.config.sources import add_config_arguments, from_arguments
from service.wire import Health, ModelSnapshot


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--wait", type=float, default=3.0, help="how long to try [s] (default 3)")
    add_config_arguments(parser)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    config = from_arguments(args)
    try:
        with reaching(config, args.wait) as client:
            health, model = look(client)
    except NoAnswer as error:
        print(f"incsvr status: {error}", file=sys.stderr)
        return 1
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
