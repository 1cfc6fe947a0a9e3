"""`incsvr status`: one screen of what a running learner hears and makes of it; exit status 0 where health is OK."""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from incsvr.plant.axes import YAW, Axis
from service.bus.client import Client, bus_client
from service.cli.console import Console
from service.cli.display import screen
from service.cli.output import WIDTH, emit
from service.cli.vehicle_display import AxisState, vehicle_screen
from service.commands.arguments import add_question_arguments
from service.config.sources import from_arguments
from service.wire import Health, Keys, ModelSnapshot


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_question_arguments(parser, wait_s=3.0)


NO_AXES: Mapping[str, AxisState] = {}
"""A learner that is the only one of its vehicle."""


def run(args: argparse.Namespace) -> int:
    config = from_arguments(args)
    with bus_client(config, args.wait) as client:
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
        "health": state.health.model_dump(mode="json"),
        "model": None if model is None else model.model_dump(mode="json"),
    }
