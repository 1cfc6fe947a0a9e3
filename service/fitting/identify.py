"""`identify`: the model of a whole vehicle from recordings, and its errors on unseen ones."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Streams
from incsvr.plant.axes import AXES, YAW, Axis
from incsvr.plant.mass_and_coriolis import mass_matrix
from incsvr.plant.words import words_of
from incsvr.vehicle import Identified, Parameter, Vehicle
from incsvr.vehicle import identify as identify_vehicle
from incsvr.vehicle.identify import STEPS
from incsvr.vehicle.model import beaten
from incsvr.vehicle.runs import axes_of, prepared
from service.cli.extras import plots
from service.cli.next_command import LOG_FLAGS, with_next
from service.cli.output import refuse_replacing, writing
from service.cli.progress import progress
from service.config.configuration import Config
from service.config.sources import read as read_config
from service.config.vehicle_file import MARK, is_name, read_values, write_vehicle
from service.fitting.each_log import refuse_dives
from service.fitting.good_enough import Use, good_enough, good_enough_lines, without_gyro
from service.fitting.parameters import parameters
from service.fitting.request import Request, read_body
from service.fitting.results import SHOWS_STREAMS, frame
from service.fitting.sensors import examine_sensors, with_heading_sign
from service.number import number_of
from service.recordings.log_refusals import beside_assumptions, notes_of, refuse_twice
from service.recordings.reading import Reading
from service.recordings.recording import Recording
from service.wire.section import entries_of

TAKES = ("inputs", "vehicle.mass_matrix")
"""The values of the configuration that `identify` and `compare` use."""
Began = Callable[[str, int], None]
"""Callback that is given each step as it begins, and the number of steps."""


@dataclass(frozen=True, slots=True, repr=False)
class WholeVehicle:
    """The result of `identify`; `str` is the text that the command prints.

    Attributes:
        found: the model of the vehicle, and its errors.
        notes: what the readers of the logs remark.
        request: what was asked.
        written: the vehicle file that holds it; None where none does.
    """

    found: Identified
    notes: tuple[str, ...]
    request: Request
    written: Path | None = None

    def to_dict(self) -> dict[str, Any]:
        """The JSON that the command writes with `--json`."""
        axes = {name: good_enough([use]) for name, use in uses(self.found).items()}
        return {**self.found.to_dict(), "notes": list(self.notes), "good_enough": axes, "next": self.next[0]}

    def __repr__(self) -> str:
        return with_next(text(self.found, self.written), *self.next)

    @property
    def next(self) -> tuple[str | None, str]:
        """The command that follows, if one does, and what it does."""
        request = self.request
        if beaten(self.found.vehicle.beaten_by):
            return request.following("inspect", LOG_FLAGS, files=request.recordings[:1]), SHOWS_STREAMS
        if self.written is None:
            more = ("--write", "vehicle.yaml")
            return request.following("identify", (*LOG_FLAGS, "vehicle", "set"), *more), "keeps the model"
        script = f"{self.written.stem}.py"
        command = shlex.join(["incsvr", "export", str(self.written), "--format", "python", "--out", script])
        return command, "makes a simulator of it"

    def write(self, path: str | Path) -> WholeVehicle:
        """Writes the vehicle file, from which `incsvr serve`, `export` and `simulate` go on; the result that says so.

        Raises:
            BadInput: it cannot be written.
        """
        refuse_replacing(Path(path), MARK, "--write")
        with writing(Path(path), "--write"):
            write_vehicle(Path(path), self.found.vehicle)
        return replace(self, written=Path(path))

    def plot(self) -> Any:
        """Prediction errors of every axis some seconds ahead, as a figure of matplotlib."""
        return plots().of_vehicle(self.found)

    def to_frame(self) -> Any:
        """One row for each parameter of each axis, with its interval, as a DataFrame of pandas."""
        return frame(
            [
                {"axis": pair[0], "parameter": _with_other(name, pair), "unit": unit, **p.to_dict()}
                for pair, name, unit, p in parameters(self.found.vehicle)
            ]
        )


def identify(request: Request, began: Began = lambda step, count: None) -> WholeVehicle:
    """Identifies a whole vehicle, all axes together.

    Args:
        request: the logs, and what is said of them.

    Raises:
        BadInput: the logs, or what is said of them, cannot be used; one sentence with the cure.
    """
    if not is_name(request.name):
        raise BadInput("--name: give the vehicle a name of one line")
    given = {} if request.vehicle is None else declared_by_file(request.vehicle)
    config, masses = configured(request)
    reading = body_reading(request, config)
    runs, unseen = read_body(reading, request.recordings), read_body(reading.whole, request.validate)
    with beside_assumptions(notes_of([*runs, *unseen])):
        found = _of_recordings(runs, unseen, given | masses, request.name, began)
    of_file = () if request.vehicle is None else (f"known inertias of {request.vehicle} are declared, not estimated",)
    notes = tuple(dict.fromkeys((*of_file, *(note for run in (*runs, *unseen) for note in run.notes))))
    return WholeVehicle(found, notes, request)


def _of_recordings(
    runs: list[Recording], unseen: list[Recording], given: Mapping[tuple[str, str], float], name: str, began: Began
) -> Identified:
    refuse_twice([*runs, *unseen])
    refuse_dives(runs, unseen)
    motion = prepared([run.own_streams for run in runs])
    test = prepared([run.own_streams for run in unseen]) if unseen else None
    if test is not None:
        _refuse_other_axes(axes_of(motion), axes_of(test), unseen)
    count = STEPS + len(axes_of(motion))
    with progress("identifying", count) as advance:

        def begins(step: str) -> None:
            began(step, count)
            advance(step)

        found = identify_vehicle(motion, test, given, name, begins=begins)
    refuse_stuck(runs, found.vehicle)
    refuse_runaway(motion, found.vehicle)
    return found


def body_reading(request: Request, config: Config) -> Reading:
    """The settings by which the logs of a whole vehicle are read."""
    return replace(request, axis=YAW.name).reading(config)


def configured(request: Request) -> tuple[Config, dict[tuple[str, str], float]]:
    """The configuration, whose inputs say what is in the logs, and the entries of M that are set.

    Raises:
        BadInput: naming what is wrong, and what is allowed there.
    """
    flags, origin = request.values_set(TAKES)
    mass = flags.pop("vehicle", {}).get("mass_matrix")
    return read_config(request.config, flags, origin), {} if mass is None else declared(mass)


def declared(given: Any) -> dict[tuple[str, str], float]:
    """The entries of M in a value of `vehicle.mass_matrix`; of six numbers, a zero leaves the entry to be estimated.

    Raises:
        BadInput: the entries are no numbers, or of no body.
    """
    found = entries_of(given)
    try:
        entries = [number_of(str(each)) for each in (found if isinstance(found, list) else [found])]
    except ValueError:
        raise BadInput(
            f"--set vehicle.mass_matrix={given}: give six numbers from surge to yaw, or 36, with commas between"
        ) from None
    matrix = mass_matrix(entries)
    names = list(AXES)
    found = {(name, name): float(matrix[k, k]) for k, name in enumerate(names) if matrix[k, k] > 0.0}
    if len(entries) == 36:
        found |= {
            (names[row], names[column]): float(matrix[row, column]) for row in range(6) for column in range(row + 1, 6)
        }
    return found


def declared_by_file(path: Path) -> dict[tuple[str, str], float]:
    """The entries of M in a vehicle file, without those that it says are unknown.

    Raises:
        BadInput: it is no vehicle file.
    """
    found = {}
    for pair, entry in read_values(path)["mass_matrix"].items():
        if entry.get("origin") in (None, "estimated", "declared"):
            row, column = sorted(pair.split(","), key=list(AXES).index)
            found[row, column] = float(entry["value"])
    return found


def _refuse_other_axes(axes: Sequence[str], unseen_axes: Sequence[str], unseen: list[Recording]) -> None:
    """Refuses dives for the errors that lack a velocity of the model."""
    missing = [name for name in axes if name not in unseen_axes]
    if missing:
        raise BadInput(
            f"{unseen[0].name}: it lacks {' and '.join(missing)}, which the model predicts; validate on dives with "
            "the same velocities"
        )


def refuse_stuck(runs: Sequence[Recording], vehicle: Vehicle) -> None:
    """Refuses dives in which a velocity stood still under a changing effort, by the checks of `incsvr trace`.

    Raises:
        BadInput: naming the dive, the velocity and the time.
    """
    for axis in (AXES[name] for name in vehicle.driven):
        seen = [each for each in (_along(run, axis) for run in runs) if each is not None]
        inertia = vehicle.mass[axis.name, axis.name].value
        with_heading_sign(seen, examine_sensors(seen, inertia, sign_known=True))


RUNAWAY = 5.0
"""Velocities beyond this multiple of the largest recorded one are those of a model that runs away."""


def refuse_runaway(runs: Sequence[Streams], vehicle: Vehicle) -> None:
    """Refuses a model whose free run over its own dives leaves all that they recorded.

    Raises:
        BadInput: naming the axes, and what to record.
    """
    reached = np.max([np.abs(vehicle.free_run(run)[1]).max(axis=0) for run in runs], axis=0)
    passed = reached >= RUNAWAY * vehicle.fastest
    away = [name for name, beyond in zip(AXES, passed, strict=True) if name in vehicle.axes and beyond]
    if away:
        raise BadInput(
            f"the model runs away: simulated over its own dives, it passes {RUNAWAY:g} times the fastest recorded "
            f"velocity of {' and '.join(away)}; nothing is written: record steps of the effort to both sides, each "
            "held until the speed settles"
        )


def _along(run: Recording, axis: Axis) -> Recording | None:
    """A dive as a recording of one axis; None where it lacks its velocity or effort."""
    streams = run.own_streams
    if any(name not in streams or not streams[name][0].size for name in (axis.rate, axis.effort)):
        return None
    return replace(run, axis=axis)


def uses(found: Identified) -> dict[str, Use]:
    """Axis → the verdict on its free run, of all axes at once."""
    errors = found.errors
    rows = zip(errors.axes, errors.free_run.tolist(), errors.zero.tolist(), errors.hold.tolist(), strict=True)
    return {name: without_gyro(model, zero, hold, words_of(AXES[name])) for name, model, zero, hold in rows}


HORIZON_HEAD = "  {:<28}{}"


def text(found: Identified, written: Path | None = None) -> str:
    """The result for people; `written` is the vehicle file."""
    vehicle = found.vehicle
    lines = [
        *found.verdict,
        f"vehicle {vehicle.name}: {found.seconds:.0f} s of motion, steps of {found.step:.3g} s",
        "",
    ]
    inertia = "effective inertia" if found.effective else "inertia"
    for axis in vehicle.axes:
        passive = "" if axis in vehicle.driven else " (no effort acts along it)"
        lines.append(f"{axis}{passive}")
        for pair, name, unit, p in parameters(vehicle):
            if pair[0] == axis:
                lines.append(_row(_with_other(inertia if name == "inertia" else name, pair), p, unit))
    lines += ["", *_errors(found)]
    if found.effective:
        lines.append("An effective inertia includes the share of axes that move with it and are not in the recordings.")
    for axis, why in found.refusals.items():
        lines.append(f"{axis} is not identified: {why}")
    lines += list(found.manoeuvres)
    lines += [f"warning: {each}" for each in found.warnings]
    if written is not None:
        lines += ["", f"written to {written}"]
    return "\n".join([*lines, "", *good_enough_lines(uses(found).values())])


def _with_other(name: str, pair: tuple[str, str]) -> str:
    """The name of a parameter along the first axis, where it couples another one."""
    return name if pair[0] == pair[1] else f"{name} with {pair[1]}"


def _row(name: str, parameter: Parameter, unit: str) -> str:
    value = f"{parameter.value:.4g}"
    if parameter.origin in ("declared", "assumed"):
        return f"  {name:<26}{value:>10}  {unit} ({parameter.origin})"
    remark = "" if parameter.origin == "estimated" else f" ({parameter.origin})"
    unit = "" if unit == "1" else unit
    return f"  {name:<26}{value:>10}  ({parameter.low:.4g} to {parameter.high:.4g}) {unit}{remark}".rstrip()


def _errors(found: Identified) -> list[str]:
    """RMS errors of predictions of all axes at once."""
    where = "other recordings" if found.unseen else "each part of the recordings, predicted by the others"
    errors = found.errors
    head = "".join(f"{axis:>12}" for axis in errors.axes)
    units = "".join(f"{'[m/s]' if AXES[axis].along else '[rad/s]':>12}" for axis in errors.axes)
    lines = [f"prediction error (RMS) on {where}, all axes at once", f"  {'':<28}{head}", f"  {'':<28}{units}"]
    for seconds, (model, hold, _) in errors.horizons.items():
        alone = [found.by_itself[axis].horizons.get(seconds) for axis in errors.axes]
        lines.append(HORIZON_HEAD.format(f"{seconds:g} s ahead: model", _numbers(model.tolist())))
        lines.append(HORIZON_HEAD.format("     velocity held", _numbers(hold.tolist())))
        if all(alone):
            singles = [float(each[0][0]) for each in alone if each]
            lines.append(HORIZON_HEAD.format("     each axis by itself", _numbers(singles)))
        if seconds in errors.track:
            lines.append(f"  {'     track':<28}{errors.track[seconds]:>12.3g} m")
    lines.append(HORIZON_HEAD.format("free run: model", _numbers(errors.free_run.tolist())))
    lines.append(HORIZON_HEAD.format("     velocity held", _numbers(errors.hold.tolist())))
    lines.append(HORIZON_HEAD.format("     zero velocity", _numbers(errors.zero.tolist())))
    singles = [float(found.by_itself[axis].free_run[0]) for axis in errors.axes]
    lines.append(HORIZON_HEAD.format("     each axis by itself", _numbers(singles)))
    lines.append("  Each axis by itself is given the other velocities as measured; the model predicts them, too.")
    return lines


def _numbers(values: list[float]) -> str:
    return "".join(f"{value:>12.3g}" for value in values)
