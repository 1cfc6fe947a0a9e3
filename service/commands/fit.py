"""`incsvr fit`: the online loop over recordings, with the errors of every iteration on unseen recordings."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Sequence
from dataclasses import asdict, replace
from importlib import import_module
from pathlib import Path
from typing import Any

from incsvr.learning.learner import Settings
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.body import Coupled
from incsvr.plant.words import words_of
from incsvr.signals import SignalSettings
from service.cli.next_command import AXIS_FLAGS, WRITTEN, following, next_line
from service.cli.output import add_json_argument, emit
from service.commands import config_output, fit_written, log_configuration, other_velocities
from service.commands.arguments import (
    POLICIES,
    POLICY_HELP,
    REPORT_WRITER,
    add_recordings_arguments,
    add_report_argument,
    provenance,
)
from service.commands.declaration import add_sign_argument, judge_declaration
from service.commands.each_log import refuse_idle, refuse_odd
from service.commands.fit_attempt import SMOOTHING
from service.commands.fit_result import Fit
from service.commands.fit_text import text
from service.config.configuration import Config
from service.config.sources import read as read_config
from service.config.sources import sections
from service.config.traced_effects import TracedEffects, configured_effects, read_effects
from service.recordings import declared_inertia
from service.recordings.log_refusals import beside_assumptions, notes_of, refuse_twice
from service.recordings.reading import Reading, add_log_arguments
from service.recordings.recording import Recording, sequence
from service.recordings.samples_from_recording import signals_for, with_smoothing


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_recordings_arguments(
        parser,
        "unseen recordings, used for validation alone",
        "inertia with added mass [kg m²], or estimate; else vehicle.inertia of --config",
    )
    parser.add_argument(
        "--config",
        type=Path,
        metavar="FILE",
        help="use this configuration's signals and learner; else they are scaled to the recordings",
    )
    log_configuration.add_arguments(parser, ("vehicle", "signals", "learner", "inputs"), log_configuration.VEHICLE_HELP)
    parser.add_argument(
        "--effects", type=Path, metavar="FILE", help="effects of a result of `incsvr trace --json FILE`"
    )
    parser.add_argument("--policy", choices=POLICIES, help=POLICY_HELP)
    fit_written.add_arguments(parser)
    add_report_argument(parser)
    add_sign_argument(parser)
    add_log_arguments(parser)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    axis, fit, result, words = answer(args)
    try:
        emit(args, result, words)
    finally:
        if args.report:
            import_module(REPORT_WRITER).write_fit(result, fit.pictures, args.report, axis, provenance(args))
    return 0


def answer(args: argparse.Namespace) -> tuple[Axis, Fit, dict[str, Any], str]:
    """The axis, what was learned, and the same for programs and for people in the axis's words."""
    config = read_config(args.config).of_axis(args.axis)
    goes_on = config
    if args.write is not None and args.write.is_file():
        _, goes_on = fit_written.learner_in(args.write, args.axis)
        config = config if args.config else goes_on.model_copy(update={"inputs": config.inputs})
    config = log_configuration.with_flags(config, args)
    reading = Reading.of(args, config)
    axis = reading.axis
    fit_written.check(args, goes_on, axis.name)
    fit, result, words = _fitted(args, config, reading)
    return axis, fit, result, words


def _fitted(args: argparse.Namespace, config: Config, reading: Reading) -> tuple[Fit, dict[str, Any], str]:
    """The result of a fit, for programs and for people."""
    runs, unseen = reading.of_all(args.recordings), reading.whole.of_all(args.validate)
    with beside_assumptions(notes_of([*runs, *unseen])):
        return _of_recordings(args, config, reading, runs, unseen)


def _of_recordings(
    args: argparse.Namespace, config: Config, reading: Reading, runs: list[Recording], unseen: list[Recording]
) -> tuple[Fit, dict[str, Any], str]:
    refuse_twice([*runs, *unseen])
    refuse_idle([*runs, *unseen], [reading.axis])
    if len(runs) + len(unseen) > 1:
        refuse_odd([*runs, *unseen], [reading.axis], args.assume_sign)
    torque = log_configuration.torque_set(config, args)
    coupled = other_velocities.coupled_axis(config, reading.axis, [*runs, *unseen])
    inertia, estimate = declared_inertia.inertia(args.inertia, config, runs, torque, coupled)
    inertia = inertia if estimate is None else float(f"{inertia:.5g}")  # as it is written down
    declaration = None
    if coupled is None and args.effects is None:
        declaration = judge_declaration(runs, unseen, inertia, torque, args.assume_sign)
        runs, unseen = declaration.runs, declaration.unseen
    signals, learner, effects = _settings(args, config, inertia, runs, unseen, coupled)
    fit = Fit.of(
        runs, unseen, signals, learner, _chosen(args, config), effects, coupled, config.further_inputs, declaration,
        args.assume_sign, _by_person(args, config),
    )  # fmt: skip
    words = text(fit, estimate)
    after = _next(args)
    if args.write is not None:
        of_body = config if coupled is None else _declared(config, inertia, coupled)
        of_body = of_body.model_copy(update={"inputs": reading.description.inputs})
        words += f"\n\n{fit_written.leave(args, of_body, sequence(runs), fit, _as_configured(args))}"
    words += f"\n\n{next_line(*after)}"
    result = (
        fit.to_dict()
        | {"next": after[0]}
        | declared_inertia.estimate_in_result(estimate, fit.closed_loop, fit.remarks, words_of(fit.axis))
    )
    if reading.axis != YAW:
        result |= {"axis": reading.axis.name}
    return fit, result, words


def _next(args: argparse.Namespace) -> tuple[str, str]:
    """The command that follows, and what it does."""
    if args.write is not None:
        return shlex.join(["incsvr", "serve", "--config", str(args.write)]), "continues to learn on the bus"
    if args.effects is not None:
        more = ("--effects", str(args.effects), "--write", WRITTEN)
        return following(args, "fit", args.recordings, AXIS_FLAGS, *more), "writes it down for `incsvr serve`"
    return following(args, "trace", args.recordings, AXIS_FLAGS), "finds the effects that this model lacks"


def _chosen(args: argparse.Namespace, config: Config) -> dict[str, Any]:
    """The settings of the learner that no recording decides: as configured, and those of flags."""
    settings = asdict(config.learner_settings())
    names = {"policy", "solver", "capacity", "batch", "fastest"}
    names |= log_configuration.names_set(args, "learner") | log_configuration.names_set(args, "vehicle")
    found = {} if _as_configured(args) else {name: settings[name] for name in names & settings.keys()}
    return found | ({} if args.policy is None else {"policy": args.policy})


def _by_person(args: argparse.Namespace, config: Config) -> frozenset[str]:
    """The signal settings that `--set` or the configuration sets."""
    names = config.signals.model_fields_set if _as_configured(args) else log_configuration.names_set(args, "signals")
    return frozenset(name for name in names if getattr(config.signals, name) is not None)


def _settings(
    args: argparse.Namespace,
    config: Config,
    inertia: float,
    runs: Sequence[Recording],
    unseen: Sequence[Recording],
    coupled: Coupled | None,
) -> tuple[SignalSettings, Settings | None, TracedEffects | None]:
    """The settings as configured, or scaled to the recordings without a configuration."""
    streams = () if coupled is None else coupled.streams
    if _as_configured(args):
        wanted = _declared(config, inertia, coupled)
        if args.effects:
            wanted = wanted.model_copy(update={"effects": args.effects})
        return _waiting(wanted.signal_settings(), streams), wanted.learner_settings(), configured_effects(wanted)
    torque = log_configuration.torque_set(config, args)
    signals = config_output.three_digits(signals_for(runs, inertia, runs[0].axis.fastest, torque))
    signals = _with_set(signals, args, config)
    path = args.effects or config.effects
    if path is None:
        return _waiting(signals, streams), None, None
    common = tuple(name for name in runs[0].channels if all(name in run.channels for run in (*runs, *unseen)))
    effects = read_effects(path, inertia, common, coupled)
    return _waiting(replace(signals, channels=effects.compensation.reads(common)), streams), None, effects


def _with_set(signals: SignalSettings, args: argparse.Namespace, config: Config) -> SignalSettings:
    """Scaled settings with those that `--set` sets; the torque's kind is in them already."""
    wanted = config.signal_settings()
    names = log_configuration.names_set(args, "signals") | log_configuration.names_set(args, "vehicle")
    if SMOOTHING in names:
        signals = with_smoothing(signals, wanted.smoothing)
    names &= {"sample_period", "lateness", "gap", "channels", "rate_limit", "torque_limit"}
    return replace(signals, **{name: getattr(wanted, name) for name in names})


def _as_configured(args: argparse.Namespace) -> bool:
    """Whether a file says how to learn; one that says only what is in a log leaves the scales to the recordings."""
    return args.config is not None and not sections(args.config) <= {"inputs"}


def _declared(config: Config, inertia: float, coupled: Coupled | None) -> Config:
    """The configuration of a vehicle with this inertia [kg m²], or in this body."""
    mass = None if coupled is None else tuple(coupled.mass.ravel().tolist())
    vehicle = config.vehicle.model_copy(update={"inertia": inertia, "mass_matrix": mass})
    return config.model_copy(update={"vehicle": vehicle})


def _waiting(signals: SignalSettings, streams: Sequence[str]) -> SignalSettings:
    """The settings of samples that wait for these streams, too."""
    return replace(signals, channels=tuple(dict.fromkeys((*signals.channels, *streams))))
