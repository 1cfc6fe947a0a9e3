"""What `fit --write` leaves for `serve`: the values that it learned with, and the state of the learner."""

from __future__ import annotations

import argparse
import re
import uuid
from dataclasses import replace
from pathlib import Path
from typing import Any

from incsvr.checks import State as Checks
from incsvr.errors import BadInput
from incsvr.learning.driven_motion import Recent
from incsvr.numerics.plain import to_plain
from incsvr.plant.axes import AXES
from service.cli.output import refuse_unwritable, writing
from service.commands import config_output
from service.commands.fit_result import Fit
from service.config.configuration import Config, validate
from service.config.core_yaml import Place, with_values
from service.config.sources import read as read_config
from service.config.traced_effects import configured_effects
from service.learner.node import LearnerNode
from service.learner.published import report
from service.recordings.recording import Recording
from service.state.disk_refusals import unwritable
from service.state.store import Store
from service.wire import encode

HEAD = "# By `incsvr fit` on "
"""The begin of the first line of a file that was written here."""
FLAGS = ("name", "state", "force")
"""The flags that need --write."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--write",
        type=Path,
        metavar="FILE",
        help="write a configuration from which `serve` continues; in a file that is there only fitted values change",
    )
    parser.add_argument("--name", metavar="N", help="name of the vehicle in it; its keys then begin with N/AXIS")
    parser.add_argument("--state", type=Path, metavar="DIR", help="directory of the state (default: as FILE has it)")
    parser.add_argument("--force", action="store_true", help="replace a state that is there")


def learner_in(path: Path, axis: str | None) -> tuple[Place, Config]:
    """The learner of an axis in a configuration file, the first one of None, and the place of its values.

    Raises:
        BadInput: it has none.
    """
    whole = read_config(path)
    for name, each in whole.named().items():
        if axis in (None, each.vehicle.axis):
            return ("learners", name) if name else (), each
    raise BadInput(f"{path} has no learner of {axis}; list one in `learners`, or name another file with --write")


def check(args: argparse.Namespace, config: Config, axis: str) -> None:
    """Refuses what cannot be left, before the work is done.

    Args:
        config: of the learner that is to continue, without the flags.
        axis: its name.
    """
    given = next((name for name in FLAGS if getattr(args, name)), None)
    if args.write is None:
        if given is not None:
            raise BadInput(f"--{given} is about what --write FILE leaves; give both, or none")
        return
    refuse_unwritable(args.write, "--write")
    if args.name is not None:
        wanted = {"vehicle": {"name": args.name}, "prefix": f"{args.name}/{axis}"}
        validate(wanted, {("vehicle", "name"): "--name", ("prefix",): "--name"})
    directory, prefix = args.state or config.state, config.prefix if args.name is None else f"{args.name}/{axis}"
    place = None if directory is None else directory / f"{prefix}.sqlite"
    if place is not None and place.exists() and not args.force:
        raise BadInput(
            f"the state {place} is there already; --force sets it aside, --name and --state name another one"
        )
    why_not = None if place is None else unwritable(place, "name another directory with --state")
    if why_not is not None:
        raise BadInput(f"no state can be left: {why_not}")


def leave(args: argparse.Namespace, config: Config, recording: Recording, fit: Fit, configured: bool) -> str:
    """Writes the configuration and the state; the sentence that says what was written.

    Args:
        config: with which it was fitted.
        recording: what was learned from, joined.
        configured: the settings are those of the configuration; else they were scaled to the recording.
    """
    path, axis = args.write, recording.axis.name
    config = _fitted(args, config, recording, fit, configured)
    head = f"{HEAD}{fit.name}, {fit.samples} samples."
    tried, said = path.with_name(f"{path.name}.new"), f"written to {path}"
    try:
        with writing(path, "--write"):
            if path.exists():
                said = _change(path, tried, config, head, args)
            else:
                config_output.write(tried, config, f"{head}\n")
        written = learner_in(tried, axis)[1]  # as `serve` will read it
        state = None if written.state is None else _leave_state(written.state, written, fit)
        with writing(path, "--write"):
            path.write_text(tried.read_text(encoding="utf-8"), encoding="utf-8")
    finally:
        tried.unlink(missing_ok=True)
    if state is None:
        return f"{said}; it says state: null, so `incsvr serve` starts with an empty model (--state DIR keeps this one)"
    return f"{said}; the state is {state}"


def _fitted(args: argparse.Namespace, config: Config, recording: Recording, fit: Fit, configured: bool) -> Config:
    """The configuration with what the fit had in force, and what the flags say."""
    if configured:
        found = {name: getattr(fit.signals, name) for name in ("torque", "smoothing", "gap")}
        parts = {
            "vehicle": {"inertia": fit.signals.inertia},
            "signals": found,
            "learner": {"policy": fit.learner.policy},
        }
        config = config.model_copy(
            update={name: getattr(config, name).model_copy(update=part) for name, part in parts.items()}
        )
    else:
        config = config_output.scaled_config(config, recording, fit.signals, fit.learner)
    told: dict[str, Any] = {"effects": args.effects} if args.effects else {}
    told |= {"state": args.state} if args.state is not None else {}
    vehicle = {"axis": recording.axis.name}
    if args.name is not None:
        told["prefix"] = f"{args.name}/{recording.axis.name}"
        vehicle["name"] = args.name
    return config.model_copy(update=told | {"vehicle": config.vehicle.model_copy(update=vehicle)})


def _change(path: Path, to: Path, config: Config, head: str, args: argparse.Namespace) -> str:
    """Writes a file that is there to another one with what was fitted, and says which values that were."""
    place, before = learner_in(path, config.vehicle.axis)
    values = {(*place, *name): value for name, value in _differences(before, config, args).items()}
    text = re.sub(f"^{HEAD}.*$", lambda _: head, path.read_text(encoding="utf-8"), count=1, flags=re.MULTILINE)
    to.write_text(with_values(text, values, str(path)), encoding="utf-8")
    return f"changed in {path}: {', '.join('.'.join(name) for name in values) or 'nothing'}"


def _differences(before: Config, after: Config, args: argparse.Namespace) -> dict[Place, Any]:
    """What a fit decides and its flags say, where a learner has other values."""
    old, new = (each.model_dump(mode="json") for each in (before, after))
    flagged = {("vehicle", "name"), ("prefix",)} if args.name is not None else set()
    flagged |= {("state",)} if args.state is not None else set()
    places = [("effects",), *flagged]
    kept = {"name"} | ({"inertia"} if after.vehicle.mass_matrix is not None else set())
    places += [("vehicle", name) for name in new["vehicle"] if name not in kept]
    places += [(section, name) for section in ("signals", "learner") for name in new[section]]
    said = {("vehicle", "inertia")} if not before.vehicle.inertia_said else set()

    def at(values: dict[str, Any], place: Place) -> Any:
        return values[place[0]] if len(place) == 1 else values[place[0]][place[1]]

    return {place: at(new, place) for place in places if place in said or at(old, place) != at(new, place)}


def _leave_state(directory: Path, config: Config, fit: Fit) -> Path:
    """Leaves what was learned as revision 1 of a learner whose clock begins with the first stamp of the bus."""
    effects = configured_effects(config)
    learner = replace(fit.guarded.learner, recent=Recent())
    known = fit.guarded.checks
    checks = Checks(learned=known.learned, rates=known.rates)  # the bus may have streams of other rates
    memory = {
        **to_plain(replace(fit.guarded, learner=learner, checks=checks, before=None)),
        "revision": 1,
        "covered": [None] * config.learner_settings().bins,
        "t": None,
    }
    node = LearnerNode(config, uuid.uuid4().hex[:12], memory=memory, effects=effects)
    last, snapshot = fit.iterations[-1], node.latest()
    assert snapshot is not None
    inside = (fit.pictures.samples.time >= last.time_span[0]) & (fit.pictures.samples.time <= last.time_span[1])
    batch = fit.pictures.samples.take(inside)
    ends = float(batch.time[-1])
    told = report(
        replace(last, time_span=(last.time_span[0] - ends, 0.0)),
        replace(batch, time=batch.time - ends),
        node.served,
        boot=node.boot,
        predicted=None,
        training_s=0.0,
        validation={},
        learned=0.0,
        axis=AXES[config.vehicle.axis],
    )
    store = Store(directory, config, None if effects is None else effects.identity, config.tracing.on, anew=True)
    try:
        store.save(node.memory(), 1, snapshot.t, encode(snapshot), encode(told))
        if store.problem is not None:
            raise BadInput(f"the state cannot be written: {store.problem}")
    finally:
        store.close()
    return store.path
