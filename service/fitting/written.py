"""What `fit --write` leaves for `serve`: the values that it learned with, and the state of the learner."""

from __future__ import annotations

import re
import uuid
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from incsvr.checks import State as Checks
from incsvr.errors import BadInput
from incsvr.learning.driven_motion import Recent
from incsvr.numerics.plain import to_plain
from incsvr.plant.axes import AXES
from service.cli.output import refuse_unwritable, writing
from service.config.configuration import Config, validate
from service.config.core_yaml import Place, with_values
from service.config.sources import read as read_config
from service.config.traced_effects import configured_effects
from service.fitting import scaled
from service.fitting.request import Request
from service.fitting.settings import as_configured
from service.learner.node import LearnerNode
from service.learner.published import report
from service.state.disk_refusals import unwritable
from service.state.memory import Memory
from service.state.store import Store
from service.wire import encode

if TYPE_CHECKING:
    from service.fitting.fit import Fit

HEAD = "# By `incsvr fit` on "
"""The begin of the first line of a file that was written here."""


@dataclass(frozen=True, slots=True)
class Destination:
    """Where a fit is left.

    Attributes:
        path: the configuration; in a file that is there only fitted values change.
        name: of the vehicle in it; None leaves it.
        state: directory of the state; None leaves what the file has.
        force: whether a state that is there is set aside.
    """

    path: Path
    name: str | None = None
    state: Path | None = None
    force: bool = False


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


def base(to: Destination, request: Request) -> Config:
    """The configuration by which a fit that is left there is made.

    Raises:
        BadInput: the fit cannot be left there, which is said before the work is done.
    """
    config = read_config(request.config).of_axis(request.axis)
    learner = learner_in(to.path, request.axis)[1] if to.path.is_file() else config
    if to.path.is_file() and request.config is None:
        config = learner.model_copy(update={"inputs": config.inputs})
    _check(to, learner, request.axis or config.vehicle.axis)
    return config


def _check(to: Destination, config: Config, axis: str) -> None:
    refuse_unwritable(to.path, "--write")
    if to.name is not None:
        wanted = {"vehicle": {"name": to.name}, "prefix": f"{to.name}/{axis}"}
        validate(wanted, {("vehicle", "name"): "--name", ("prefix",): "--name"})
    directory, prefix = to.state or config.state, config.prefix if to.name is None else f"{to.name}/{axis}"
    place = None if directory is None else directory / f"{prefix}.sqlite"
    if place is not None and place.exists() and not to.force:
        raise BadInput(
            f"the state {place} is there already; --force sets it aside, --name and --state name another one"
        )
    why_not = None if place is None else unwritable(place, "name another directory with --state")
    if why_not is not None:
        raise BadInput(f"no state can be left: {why_not}")


def leave(fit: Fit, to: Destination) -> str:
    """Writes the configuration and the state; the sentence that says what was written.

    Raises:
        BadInput: one of them cannot be written.
    """
    path, axis = to.path, fit.axis.name
    config = _fitted(fit, to)
    head = f"{HEAD}{fit.name}, {len(fit.training.samples)} samples."
    tried, said = path.with_name(f"{path.name}.new"), f"written to {path}"
    try:
        with writing(path, "--write"):
            if path.exists():
                said = _change(to, tried, config, head)
            else:
                scaled.write(tried, config, f"{head}\n")
        written = learner_in(tried, axis)[1]  # as `serve` will read it
        state = None if written.state is None else _leave_state(written.state, written, fit)
        with writing(path, "--write"):
            path.write_text(tried.read_text(encoding="utf-8"), encoding="utf-8")
    finally:
        tried.unlink(missing_ok=True)
    if state is None:
        return f"{said}; it says state: null, so `incsvr serve` starts with an empty model (--state DIR keeps this one)"
    return f"{said}; the state is {state}"


def _fitted(fit: Fit, to: Destination) -> Config:
    """The configuration with what the fit had in force, and what its destination says."""
    config, signals, learner, axis = fit.config, fit.training.signals, fit.training.settings, fit.axis.name
    if as_configured(fit.request):
        found = {name: getattr(signals, name) for name in ("torque", "smoothing", "gap")}
        parts = {"vehicle": {"inertia": signals.inertia}, "signals": found, "learner": {"policy": learner.policy}}
        config = config.model_copy(
            update={name: getattr(config, name).model_copy(update=part) for name, part in parts.items()}
        )
    else:
        config = scaled.scaled_config(config, fit.joined, signals, learner)
    told: dict[str, Any] = {"effects": fit.request.effects} if fit.request.effects else {}
    told |= {"state": to.state} if to.state is not None else {}
    vehicle = {"axis": axis}
    if to.name is not None:
        told["prefix"] = f"{to.name}/{axis}"
        vehicle["name"] = to.name
    return config.model_copy(update=told | {"vehicle": config.vehicle.model_copy(update=vehicle)})


def _change(to: Destination, tried: Path, config: Config, head: str) -> str:
    """Writes a file that is there to another one with what was fitted, and says which values that were."""
    path = to.path
    place, before = learner_in(path, config.vehicle.axis)
    values = {(*place, *name): value for name, value in _differences(before, config, to).items()}
    text = re.sub(f"^{HEAD}.*$", lambda _: head, path.read_text(encoding="utf-8"), count=1, flags=re.MULTILINE)
    tried.write_text(with_values(text, values, str(path)), encoding="utf-8")
    return f"changed in {path}: {', '.join('.'.join(name) for name in values) or 'nothing'}"


def _differences(before: Config, after: Config, to: Destination) -> dict[Place, Any]:
    """What a fit decides and its flags say, where a learner has other values."""
    old, new = (each.model_dump(mode="json") for each in (before, after))
    flagged = {("vehicle", "name"), ("prefix",)} if to.name is not None else set()
    flagged |= {("state",)} if to.state is not None else set()
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
    learner = replace(fit.training.guarded.learner, recent=Recent())
    known = fit.training.guarded.checks
    checks = Checks(learned=known.learned, rates=known.rates)  # the bus may have streams of other rates
    memory = Memory(learner, checks, revision=1, covered=(None,) * config.learner_settings().bins, t=None)
    node = LearnerNode(config, uuid.uuid4().hex[:12], memory=to_plain(memory), effects=effects)
    last, snapshot = fit.training.iterations[-1], node.latest()
    assert snapshot is not None
    inside = (fit.training.samples.time >= last.time_span[0]) & (fit.training.samples.time <= last.time_span[1])
    batch = fit.training.samples.take(inside)
    ends = float(batch.time[-1])
    told = report(
        replace(last, time_span=(last.time_span[0] - ends, 0.0)),
        replace(batch, time=batch.time - ends),
        node.served,
        predicted=None,
        axis=AXES[config.vehicle.axis],
        validation={},
        learned=0.0,
    )
    store = Store(directory, config, None if effects is None else effects.identity, config.tracing.on, anew=True)
    try:
        store.save(node.memory(), 1, snapshot.t or 0.0, encode(snapshot), encode(told))
        if store.problem is not None:
            raise BadInput(f"the state cannot be written: {store.problem}")
    finally:
        store.close()
    return store.path
