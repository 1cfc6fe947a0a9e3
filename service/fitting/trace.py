"""`trace`: the physical effects that the declared model lacks, of one axis."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.words import words_of
from incsvr.signals.settings import TorqueKind
from incsvr.tracing import result
from incsvr.tracing.findings import Trace
from incsvr.tracing.run import Run
from incsvr.tracing.sentences import chance, headline, limits, proof
from service.cli.extras import plots
from service.cli.next_command import AXIS_FLAGS, LOG_FLAGS, WRITTEN, with_next
from service.cli.progress import progress
from service.fitting import declared as of_inertia
from service.fitting import other_velocities
from service.fitting.declaration import DOUBT_HEADLINE, judge_declaration
from service.fitting.declared import Declared
from service.fitting.each_log import refuse_idle, refuse_odd
from service.fitting.good_enough import Use, closed_loop, feed_forward, good_enough, good_enough_lines, without_gyro
from service.fitting.other_velocities import NO_OTHER_VELOCITIES, OtherVelocities
from service.fitting.request import Request
from service.fitting.results import SHOWS_STREAMS, frame
from service.fitting.sensors import examine_sensors, sensor_notes, with_heading_sign
from service.recordings.log_refusals import beside_assumptions, notes_of, refuse_twice
from service.recordings.recording import Recording

TAKES = ("vehicle", "inputs", "signals.torque")
"""The values of the configuration that `trace` uses."""


@dataclass(frozen=True, slots=True, repr=False)
class Traced:
    """The result of `trace`; `str` is the text that the command prints.

    Attributes:
        found: effects, errors, what is unexplained.
        axis: whose words it is in.
        others: what the other velocities of the body are to it.
        request: what was asked.
        keeps: the file in which a command keeps it; None where it does not.
    """

    found: Trace
    axis: Axis
    others: OtherVelocities
    request: Request
    keeps: str | None = None

    def to_dict(self) -> dict[str, Any]:
        """The JSON that the command writes with `--json`."""
        found = self.found
        told = {"headline": headline(found), "limits": limits(found), **found.to_dict(), "axis": self.axis.name}
        return told | {"good_enough": good_enough(uses(found)), "next": self.next[0]} | self.others.to_dict()

    def __repr__(self) -> str:
        return with_next(text(self.found), *self.next)

    @property
    def next(self) -> tuple[str | None, str]:
        """The command that follows, if one does, and what it does."""
        found, request = self.found, self.request
        if not found.beats_zero or not found.sought:
            return request.following("inspect", LOG_FLAGS, files=request.recordings[:1]), SHOWS_STREAMS
        if not found.effects:
            command = request.following("fit", AXIS_FLAGS, "--write", WRITTEN)
            return command, "learns the curve and writes it down for `incsvr serve`"
        if self.keeps is None:
            command = request.following("trace", AXIS_FLAGS, "--json", "effects.json")
            return command, "keeps the effects, for `incsvr fit --effects`"
        return request.following("fit", AXIS_FLAGS, "--effects", self.keeps), "learns the curve with these effects"

    def plot(self) -> Any:
        """A free run on unseen data, before and after, as a figure of matplotlib."""
        return plots().of_trace(self.found, self.axis)

    def to_frame(self) -> Any:
        """One row for each parameter of each effect, as a DataFrame of pandas."""
        columns = ("effect", "parameter", "estimate", "low", "high", "p_value", "share")
        rows = [
            (each["effect"], name, value, *each["interval"].get(name, (None, None)), each["p_value"], each["share"])
            for each in self.found.to_dict()["effects"]
            for name, value in each["parameters"].items()
        ]
        return frame([dict(zip(columns, row, strict=True)) for row in rows], columns)


def trace(request: Request, keeps: str | None = None) -> Traced:
    """Finds the effects that the declared model of one axis lacks.

    Args:
        request: the logs, and what is said of them.
        keeps: the file in which a command keeps the result.

    Raises:
        BadInput: the logs, or what is said of them, cannot be used; one sentence with the cure.
    """
    config = request.configured(TAKES)
    reading = replace(request.reading(config), ours_whole=True)
    axis, words = reading.axis, words_of(reading.axis)
    runs, unseen = request.read(reading)
    recordings, parts, others = [*runs, *unseen], dict[str, Array](), NO_OTHER_VELOCITIES
    with beside_assumptions(notes_of(recordings)):
        refuse_twice(recordings)
        refuse_idle(recordings, [axis])
        if len(recordings) > 1:
            refuse_odd(recordings, [axis], request.assume_sign)
        declared = Declared.of(request, config, axis, runs, recordings).beside_effects
        if declared.coupled is not None:
            recordings, parts, others = other_velocities.freed_recordings(declared.coupled, recordings)
        said = (declared.inertia, declared.torque, reading.rate_limit, request.assume_sign)
        found = trace_recordings(recordings[: len(runs)], recordings[len(runs) :], *said)
    notes = found.notes
    if (estimate := declared.estimate) is not None:
        doubt = of_inertia.doubt(estimate.beside_error, found.loop == "closed")
        how = (
            f"the {words.inertia} is estimated by output error, {estimate.beside:.4g}{doubt} {words.inertia_unit}: "
            f"{words.fill(of_inertia.ESTIMATE_LIMITS)}"
        )
        notes = (how, *notes)
    pictures = replace(found.pictures, ledger={**found.pictures.ledger, **parts})
    found = replace(found, notes=(*others.remarks, *notes), pictures=pictures)
    return Traced(found, axis, others, request, keeps)


def trace_recordings(
    fitted: Sequence[Recording],
    unseen: Sequence[Recording],
    inertia: float,
    torque: TorqueKind | None = None,
    rate_limit: float | None = None,
    assume_sign: bool = False,
) -> Trace:
    """The trace of recordings, with the remarks on their declaration and their sensors.

    Args:
        fitted, unseen: recordings to fit, and for the proof alone.
        inertia: I₀, declared [kg m²].
        torque: what it is; None tells it from the data.
        rate_limit: the velocity beyond which a recording is in another unit; None is what no vehicle reaches.
        assume_sign: the torque's sign is taken as it is.

    Raises:
        BadInput: where the recordings cannot answer.
    """
    declaration = judge_declaration(fitted, unseen, inertia, torque, assume_sign)
    fitted, doubt = declaration.runs, declaration.doubt
    recordings = [*fitted, *declaration.unseen]
    with progress("checking the sensors"):
        sensors = examine_sensors(recordings, inertia, assume_sign)
    runs = [replace(run, rate_limit=rate_limit) for run in runs_of(with_heading_sign(recordings, sensors))]
    try:
        with progress("tracing what the model lacks"):
            found = result.trace(runs[: len(fitted)], inertia=inertia, validate=runs[len(fitted) :], torque=torque)
    except BadInput as error:
        why = declaration.sign or doubt
        if why is None:
            raise
        # no manoeuvre helps where the inertia, or the torque's unit or sign, is wrong
        raise BadInput(f"{fitted[0].name}: {why}") from error
    others = other_velocities.coupling_of_recordings(fitted, inertia)
    beside = (*declaration.sentences, *found.notes, *(() if others is None else (others,)))
    return replace(
        found,
        notes=(*beside, *sensor_notes(recordings, sensors, found.verdict != "none")),
        doubts=(*found.doubts, *(() if doubt is None else (words_of(fitted[0].axis).fill(DOUBT_HEADLINE),))),
    )


def runs_of(recordings: Sequence[Recording]) -> list[Run]:
    """Recordings as the tracer takes them."""
    runs = []
    for recording in recordings:
        axis = recording.axis
        beside = {axis.rate, axis.effort, *(("heading",) if axis != YAW else ())}
        columns = recording.columns
        channels = {name: values for name, values in columns.items() if name not in beside}
        runs.append(Run(recording.name, recording.time, columns[axis.rate], columns[axis.effort], channels, axis.rate))
    return runs


def uses(found: Trace) -> tuple[Use, ...]:
    """What the model with the effects is good enough for."""
    words, error = words_of(found.axis), found.error
    share = error["disturbance"].get("share_of_torque", 0.0)
    effort = error["disturbance"]["torque_rmse"] / share if share else 0.0
    zero, hold = (error["trivial"][name]["free_run_rmse"] for name in ("zero", "hold"))
    free = without_gyro(error["after"]["free_run_rmse"], zero, hold, words)
    free = closed_loop(free.use, words) if found.loop == "closed" else free
    return feed_forward(error["after"]["torque_rmse"], effort, words), free


def text(trace: Trace) -> str:
    """The findings for people."""
    words = words_of(trace.axis)
    traced = (
        ""
        if trace.inertia_in_force == trace.inertia
        else f" ({trace.inertia_in_force:.3g} {words.inertia_unit} in use)"
    )
    lines = [f"declared {words.inertia} {trace.inertia:g} {words.inertia_unit}{traced}: {headline(trace)}"]
    lines += [f"  caution: {limit}" for limit in limits(trace)]
    for finding in trace.effects:
        lines.append(f"  {finding.sentence}")
        if finding.cannot_tell_from:
            rivals = ", ".join(finding.cannot_tell_from)
            lines.append(f"    these recordings cannot distinguish it from: {rivals} (either, or both at once)")
        if finding.next_manoeuvre:
            lines.append(f"    next: {finding.next_manoeuvre}")
    lines += [f"  {item.channel} still predicts the residual (p {chance(item.p_value)})" for item in trace.unexplained]
    error = trace.error
    where = (
        "the validation recordings" if error["validated_on"] == "recordings" else "held-out pieces of the recordings"
    )
    lines.append(f"  on {where}:            before       after    change (95 %)")
    for key, unit in (("torque_rmse", words.effort_unit), ("free_run_rmse", words.rate_unit)):
        change = error["change"][key]
        lines.append(
            f"    {key:14s} [{unit:5s}]   {_figure(error['before'][key]):>10s}  {_figure(error['after'][key]):>10s}    "
            f"{_change(change['estimate'])} ({_change(change['low'])} to {_change(change['high'])})"
        )
    lines += _beside(error, trace.model.scale, words.rate_unit)
    if trace.effects or trace.loop == "closed":
        lines.append(f"  {proof(trace)}")
    lines.append(f"    noise floor of the {words.effort} {_figure(error['floor']['torque_rmse'])} {words.effort_unit}")
    left = error["disturbance"]
    share = f"{100.0 * left['share_of_torque']:.1f} % of the {words.effort}, " if "share_of_torque" in left else ""
    lines.append(
        f"    residual: {left['torque_rmse']:.3g} {words.effort_unit} (RMS), {share}correlated over "
        f"{left['correlation_time_s']:.2g} s"
    )
    lines += [f"  not added: {r.effect}: {r.reason}" for r in trace.rejected if r.refused]
    lines += [f"  ignored channel {name}: {reason}" for name, reason in trace.ignored_channels.items()]
    lines += [f"  note: {note}" for note in trace.notes]
    lines += ["", *good_enough_lines(uses(trace))]
    return "\n".join(lines)


def _beside(error: Mapping[str, Any], scale: float, unit: str) -> list[str]:
    """The trivial models, and the errors a few time scales ahead, each of so many seconds."""
    zero, hold = (_figure(error["trivial"][name]["free_run_rmse"]) for name in ("zero", "hold"))
    lines = [f"    for comparison [{unit}]: zero rate {zero}, first rate held {hold}"]
    for horizon, errors in error["horizons"].items():
        said = ", ".join(f"{name} {_figure(errors[name])}" for name in ("before", "after", "hold", "zero"))
        lines.append(f"    {horizon:>4s} time scales ({float(horizon) * scale:.2g} s) ahead [{unit}]: {said}")
    return lines


def _figure(value: float) -> str:
    return f"{value:.4g}" if math.isfinite(value) else "–"


def _change(value: float) -> str:
    return f"{value:+.3g}" if math.isfinite(value) else "–"
