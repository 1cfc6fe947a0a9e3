"""`incsvr trace`: reads recordings, traces what the model lacks, prints it for people or for programs."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from incsvr.plant.axes import YAW
from incsvr.plant.words import said
from incsvr.samples import Array
from incsvr.signals.settings import TorqueKind
from incsvr.tracing import trace
from incsvr.tracing.findings import Trace
from incsvr.tracing.run import Run, distinct
from incsvr.tracing.sentences import chance
from service.config import Config
from service.config_sources import read as read_config
from service.output import add_json_argument, destination, emit
from service.progress import progress
from simulator import coupling, declared_inertia
from simulator.coupling import Told
from simulator.logs import Reading, add_log_arguments
from simulator.recordings import Recording
from simulator.trace_sensors import believed, examined, notes

REPORT_WRITER = "viewer.report"
"""Writes the HTML report; loaded when asked for, so that tracing needs no drawing library."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("recordings", nargs="+", type=Path, metavar="RECORDING", help="log of any format, one run")
    parser.add_argument("--validate", nargs="+", type=Path, default=[], metavar="RECORDING", help="runs for the proof")
    parser.add_argument(
        "--inertia", metavar="I", help="declared I [kg m²], or estimate; else vehicle.inertia of --config"
    )
    parser.add_argument(
        "--torque",
        choices=("commanded", "measured"),
        help="what the torque is: a command, or a measurement with noise of its own (default: told from the data)",
    )
    parser.add_argument("--mass-matrix", metavar="M", help=coupling.HELP)
    parser.add_argument("--report", type=destination, metavar="FILE.html", help="one self-contained file to keep")
    add_log_arguments(parser, config=True)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    config = read_config(args.config)
    reading = replace(Reading.of(args, config), ours_whole=True)
    axis = reading.axis
    try:
        found, others = _traced(args, reading, config)
    except BadInput as error:
        raise BadInput(said(axis, str(error))) from None
    if args.report:
        import_module(REPORT_WRITER).write(found, args.report, axis, _made(args))
    emit(args, {**found.to_dict(), "axis": axis.name, **others.to_dict()}, said(axis, text(found)))
    return 0


def _made(args: argparse.Namespace) -> dict[str, str]:
    """What a report was made of and how, for who finds it in a folder."""
    named = {"recordings": args.recordings, "validated on": args.validate}
    return {
        **{name: ", ".join(path.name for path in paths) for name, paths in named.items() if paths},
        "command": shlex.join(["incsvr", *sys.argv[1:]]),
        "software": f"incsvr {version('incsvr')}, numpy {version('numpy')}, scipy {version('scipy')}",
        "date": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    }


def _traced(args: argparse.Namespace, reading: Reading, config: Config) -> tuple[Trace, Told]:
    recordings = reading.of_all([*args.recordings, *args.validate])
    distinct(runs_of(recordings))
    fitted = len(args.recordings)
    of_file = config if args.config else None
    coupled = coupling.declared(args.mass_matrix, of_file, reading.axis, recordings)
    inertia, estimate = declared_inertia.inertia(args.inertia, of_file, recordings[:fitted], args.torque, coupled)
    parts, others = dict[str, Array](), coupling.NOTHING
    if coupled is not None:
        recordings, parts, others = coupling.by_itself(coupled, recordings)
    found = traced(recordings[:fitted], recordings[fitted:], inertia, args.torque, reading.rate_limit)
    if estimate is not None:
        doubt = declared_inertia.doubt(estimate, found.loop == "closed")
        how = f"the inertia is estimated by output error, {inertia:.4g}{doubt} kg m²: {declared_inertia.LIMITS}"
        found = replace(found, notes=(how, *found.notes))
    pictures = replace(found.pictures, ledger={**found.pictures.ledger, **parts})
    return replace(found, notes=(*others.remarks, *found.notes), pictures=pictures).in_terms_of(reading.axis), others


def traced(
    fitted: Sequence[Recording],
    unseen: Sequence[Recording],
    inertia: float,
    torque: TorqueKind | None = None,
    rate_limit: float | None = None,
) -> Trace:
    """What the declared model lacks, and what a reader must know of the sensors of these recordings.

    Args:
        fitted, unseen: recordings to fit, and for the proof alone.
        inertia: I₀, declared [kg m²].
        torque: what it is; None tells it from the data.
        rate_limit: the velocity beyond which a recording is in another unit; None is what no vehicle reaches.

    Raises:
        BadInput: where the recordings cannot answer.
    """
    recordings = [*fitted, *unseen]
    with progress("checking the sensors"):
        sensors = examined(recordings, inertia)
    runs = [replace(run, rate_limit=rate_limit) for run in runs_of(believed(recordings, sensors))]
    with progress("tracing what the model lacks"):
        found = trace(runs[: len(fitted)], inertia=inertia, validate=runs[len(fitted) :], torque=torque)
    others = coupling.of_recordings(fitted, inertia)
    said = (*found.notes, *(() if others is None else (others,)))
    return replace(found, notes=(*said, *notes(recordings, sensors, found.verdict != "none")))


def runs_of(recordings: Sequence[Recording]) -> list[Run]:
    """Recordings as the tracer takes them."""
    runs = []
    for recording in recordings:
        columns = dict(recording.columns)
        rate, torque = columns.pop(YAW.rate), columns.pop(YAW.effort)
        columns |= {name: values for name, values in recording.displaced.items() if name != "heading"}
        runs.append(Run(recording.name, recording.time, rate, torque, columns, recording.axis.rate))
    return runs


def text(found: Trace) -> str:
    """The findings for people."""
    lines = [f"declared inertia {found.inertia:g} kg m²: {_headline(found)}"]
    for finding in found.effects:
        lines.append(f"  {finding.sentence}")
        if finding.cannot_tell_from:
            rivals = ", ".join(finding.cannot_tell_from)
            lines.append(f"    these recordings cannot tell it from: {rivals} (either, or both at once)")
        if finding.next_manoeuvre:
            lines.append(f"    next: {finding.next_manoeuvre}")
    lines += [f"  {item.channel} still predicts the residual (p {chance(item.p_value)})" for item in found.unexplained]
    error = found.error
    where = (
        "the validation recordings" if error["validated_on"] == "recordings" else "held-out pieces of the recordings"
    )
    lines.append(f"  on {where}:            before       after    change (95 %)")
    for key, unit in (("torque_rmse", "N m"), ("free_run_rmse", "rad/s")):
        change = error["change"][key]
        lines.append(
            f"    {key:14s} [{unit:5s}]   {error['before'][key]:10.4g}  {error['after'][key]:10.4g}    "
            f"{change['estimate']:+.3g} ({change['low']:+.3g} to {change['high']:+.3g})"
        )
    lines += _beside(error)
    if found.effects or found.loop == "closed":
        lines.append(f"  {_proof(found)}")
    lines.append(f"    noise floor of the torque {error['floor']['torque_rmse']:.4g} N m")
    left = error["disturbance"]
    share = f"{left['share_of_torque']:.1%} of the torque, " if "share_of_torque" in left else ""
    lines.append(
        f"    what is left: {left['torque_rmse']:.3g} N m (RMS), {share}"
        f"correlated over {left['correlation_time_s']:.2g} s"
    )
    lines += [f"  not added: {r.effect}: {r.reason}" for r in found.rejected if "free run" in r.reason]
    lines += [f"  ignored channel {name}: {reason}" for name, reason in found.ignored_channels.items()]
    lines += [f"  note: {note}" for note in found.notes]
    return "\n".join(lines)


def _beside(error: Mapping[str, Any]) -> list[str]:
    """The trivial models, and the errors a few time scales ahead."""
    zero, hold = (error["trivial"][name]["free_run_rmse"] for name in ("zero", "hold"))
    lines = [f"    beside it [rad/s]: a rate of zero {zero:.4g}, the first rate held {hold:.4g}"]
    for horizon, errors in error["horizons"].items():
        said = ", ".join(f"{name} {errors[name]:.4g}" for name in ("before", "after", "hold", "zero"))
        lines.append(f"    {horizon:>4s} time scales ahead [rad/s]: {said}")
    return lines


def _proof(found: Trace) -> str:
    """What the errors on unseen data are worth."""
    if not found.beats_zero:
        return "a free run that errs more than a rate of zero proves nothing"
    better = "lower beyond chance" if found.proven else "not lower beyond chance"
    if found.loop == "closed":
        return (
            "closed loop: the free run is no proof, the torque answers to the water; the predicted torque's error on "
            f"unseen data is {better}"
        )
    return f"open loop: the free run on unseen data is the proof; its error is {better}"


def _headline(found: Trace) -> str:
    if not found.beats_zero:
        return "the model predicts no better than a rate of zero: check inertia, units and signs before anything else"
    if found.verdict == "effects":
        return "the model lacks " + ", ".join(finding.effect for finding in found.effects)
    if found.verdict == "unexplained":
        return "something is missing that no known effect explains"
    return "nothing is missing that these recordings could show"
