"""`incsvr trace`: reads recordings, traces what the model lacks, prints it for people or for programs."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from typing import Any

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.words import words_of
from incsvr.signals.settings import TorqueKind
from incsvr.tracing.findings import Trace
from incsvr.tracing.result import trace
from incsvr.tracing.run import Run
from incsvr.tracing.sentences import chance, headline, limits, proof
from service.cli.next_command import AXIS_FLAGS, LOG_FLAGS, WRITTEN, following, next_line
from service.cli.output import add_json_argument, emit
from service.cli.progress import progress
from service.commands import log_configuration, other_velocities
from service.commands.arguments import REPORT_WRITER, add_recordings_arguments, add_report_argument, provenance
from service.commands.declaration import DOUBT_HEADLINE, add_sign_argument, judge_declaration
from service.commands.each_log import refuse_idle, refuse_odd
from service.commands.good_enough import (
    Use,
    closed_loop,
    feed_forward,
    good_enough,
    good_enough_lines,
    without_gyro,
)
from service.commands.other_velocities import OtherVelocities
from service.commands.trace_sensors import examine_sensors, sensor_notes, with_heading_sign
from service.config.configuration import Config
from service.config.sources import read as read_config
from service.recordings import declared_inertia
from service.recordings.log_refusals import beside_assumptions, notes_of, refuse_twice
from service.recordings.reading import Reading, add_log_arguments
from service.recordings.recording import Recording


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_recordings_arguments(
        parser,
        "unseen recordings, used for validation alone",
        "declared I [kg m²], or estimate; else vehicle.inertia of --config",
    )
    log_configuration.add_arguments(parser, ("vehicle", "inputs", "signals.torque"), log_configuration.VEHICLE_HELP)
    add_report_argument(parser)
    add_sign_argument(parser)
    add_log_arguments(parser, config=True)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    axis, found, result = answer(args)
    try:
        emit(args, result, text(found, result["next"]))  # before any picture: it is kept whatever becomes of that
    finally:
        if args.report:
            import_module(REPORT_WRITER).write(found, args.report, axis, provenance(args))
    return 0


def answer(args: argparse.Namespace) -> tuple[Axis, Trace, dict[str, Any]]:
    """The axis, what was found in its words, and the same for programs."""
    config = log_configuration.with_flags(read_config(args.config).of_axis(args.axis), args)
    reading = replace(Reading.of(args, config), ours_whole=True)
    axis = reading.axis
    found, others = _traced(args, reading, config)
    told = {"headline": headline(found), "limits": limits(found), **found.to_dict(), "axis": axis.name}
    told |= {"good_enough": good_enough(uses(found)), "next": _next(args, found)}
    return axis, found, told | others.to_dict()


def _next(args: argparse.Namespace, found: Trace) -> str:
    """The command that follows."""
    if not found.beats_zero or not found.sought:
        return following(args, "inspect", args.recordings[:1], LOG_FLAGS)
    if not found.effects:
        return following(args, "fit", args.recordings, AXIS_FLAGS, "--write", WRITTEN)
    if args.json in (None, "-"):
        return following(args, "trace", args.recordings, AXIS_FLAGS, "--json", "effects.json")
    return following(args, "fit", args.recordings, AXIS_FLAGS, "--effects", args.json)


WHAT_NEXT = {
    "inspect": "shows ranges, signs and units",
    "fit": "learns the curve and writes it down for `incsvr serve`",
    "trace": "keeps the effects, for `incsvr fit --effects`",
}
"""Command that follows → what it does."""


def uses(found: Trace) -> tuple[Use, ...]:
    """What the model with the effects is good enough for."""
    words, error = words_of(found.axis), found.error
    share = error["disturbance"].get("share_of_torque", 0.0)
    effort = error["disturbance"]["torque_rmse"] / share if share else 0.0
    zero, hold = (error["trivial"][name]["free_run_rmse"] for name in ("zero", "hold"))
    free = without_gyro(error["after"]["free_run_rmse"], zero, hold, words)
    free = closed_loop(free.use, words) if found.loop == "closed" else free
    return feed_forward(error["after"]["torque_rmse"], effort, words), free


def _traced(args: argparse.Namespace, reading: Reading, config: Config) -> tuple[Trace, OtherVelocities]:
    runs = reading.of_all(args.recordings)
    recordings = [*runs, *reading.whole.of_all(args.validate)]
    with beside_assumptions(notes_of(recordings)):
        return _of_recordings(args, reading, config, recordings, len(runs))


def _of_recordings(
    args: argparse.Namespace, reading: Reading, config: Config, recordings: list[Recording], fitted: int
) -> tuple[Trace, OtherVelocities]:
    refuse_twice(recordings)
    refuse_idle(recordings, [reading.axis])
    if len(recordings) > 1:
        refuse_odd(recordings, [reading.axis], args.assume_sign)
    torque = log_configuration.torque_set(config, args)
    coupled = other_velocities.coupled_axis(config, reading.axis, recordings)
    inertia, estimate = declared_inertia.inertia(args.inertia, config, recordings[:fitted], torque, coupled)
    parts, others = dict[str, Array](), other_velocities.NO_OTHER_VELOCITIES
    if coupled is not None:
        recordings, parts, others = other_velocities.freed_recordings(coupled, recordings)
    asked = (inertia, torque, reading.rate_limit, args.assume_sign)
    found = trace_recordings(recordings[:fitted], recordings[fitted:], *asked)
    if estimate is not None:
        words = words_of(reading.axis)
        doubt = declared_inertia.doubt(estimate, found.loop == "closed")
        how = (
            f"the {words.inertia} is estimated by output error, {inertia:.4g}{doubt} {words.inertia_unit}: "
            f"{words.fill(declared_inertia.ESTIMATE_LIMITS)}"
        )
        found = replace(found, notes=(how, *found.notes))
    pictures = replace(found.pictures, ledger={**found.pictures.ledger, **parts})
    return replace(found, notes=(*others.remarks, *found.notes), pictures=pictures), others


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
            found = trace(runs[: len(fitted)], inertia=inertia, validate=runs[len(fitted) :], torque=torque)
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
        columns = dict(recording.columns)
        rate, torque = columns.pop(YAW.rate), columns.pop(YAW.effort)
        columns |= {name: values for name, values in recording.displaced.items() if name != "heading"}
        runs.append(Run(recording.name, recording.time, rate, torque, columns, recording.axis.rate))
    return runs


def text(trace: Trace, following: str = "") -> str:
    """The findings for people, and the command that follows, if one does."""
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
    if following:
        what = "learns the curve with these effects" if "--effects" in following else WHAT_NEXT[following.split()[1]]
        lines += ["", next_line(following, what)]
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
