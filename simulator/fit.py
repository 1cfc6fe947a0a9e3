"""`incsvr fit`: the online loop over recordings, with the errors of every iteration on unseen recordings."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning import guarded
from incsvr.learning.coefficients import coefficients
from incsvr.learning.excitation import MANOEUVRE, Excitation, torque_answers
from incsvr.learning.inertia import InertiaEstimate
from incsvr.learning.learner import Iteration, Settings
from incsvr.learning.motion import free_run_rmse, motions
from incsvr.learning.resolution import unresolved
from incsvr.learning.several.free_run import free_run_rmse as over_several
from incsvr.plant.axes import YAW
from incsvr.plant.body import Coupled
from incsvr.plant.words import said
from incsvr.samples import Samples
from incsvr.signals import TORQUE, SignalSettings
from incsvr.signals.checks import YOUNG, Vehicle, Verdict, told
from incsvr.signals.coupled import freed
from incsvr.signals.settings import COMMANDED, MEASURED
from incsvr.traced_motion import traced_free_run_rmse
from service.config import Config
from service.config import read as read_config
from service.effects import TracedEffects, configured, read_effects
from service.output import add_json_argument, emit
from service.progress import progress
from simulator import coupling, declared_inertia, written
from simulator.coupling import Told
from simulator.logs import Reading, add_log_arguments
from simulator.online import Errors, foreign_inertia, learner_for, remarks, samples_of, signals_for, wanted_streams
from simulator.recordings import Recording, sequence

EFFECTS_OVER_ONE = (
    "with traced effects damping is learned over one velocity, over which they were traced; leave out --effects, or "
    "the further inputs"
)
CURVE = 101
"""Rates of the trained range at which the curve is told."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "recordings", nargs="+", type=Path, metavar="RECORDING", help="logs of any format, one run each"
    )
    parser.add_argument("--validate", nargs="+", type=Path, default=[], metavar="RECORDING", help="unseen runs")
    parser.add_argument(
        "--inertia", metavar="I", help="inertia with added mass [kg m²], or estimate; else vehicle.inertia of --config"
    )
    parser.add_argument(
        "--config",
        type=Path,
        metavar="FILE",
        help="signals and learner as the service has them; else scaled to the runs",
    )
    parser.add_argument(
        "--inputs",
        metavar="NAMES",
        help="velocities that damping is learned over, the axis's own first, such as yaw_rate,surge (default: its own)",
    )
    parser.add_argument("--mass-matrix", metavar="M", help=coupling.HELP)
    parser.add_argument("--effects", type=Path, metavar="FILE", help="what `incsvr trace --json FILE` found")
    parser.add_argument(
        "--torque",
        choices=(COMMANDED, MEASURED),
        help="what the torque is: a command, which holds until the next one, or a measurement (default: told from the "
        "data, or as configured)",
    )
    parser.add_argument("--policy", choices=("paper", "weighted"), help="which samples are kept")
    parser.add_argument(
        "--write", type=Path, metavar="FILE", help="write a configuration for `serve` there, scaled as this fit is"
    )
    add_log_arguments(parser)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    written.check(args.write)
    over = {} if args.inputs is None else {"learner": {"inputs": args.inputs.split(",")}}
    if over and args.axis is not None:
        over |= {"vehicle": {"axis": args.axis}}
    config = read_config(args.config, over)
    reading = Reading.of(args, config)
    try:
        result, text = _fitted(args, config, reading)
    except BadInput as error:
        raise BadInput(said(reading.axis, str(error))) from None
    emit(args, result, said(reading.axis, text))
    return 0


def _fitted(args: argparse.Namespace, config: Config, reading: Reading) -> tuple[dict[str, Any], str]:
    """The result for programs, and for people."""
    runs, unseen = reading.of_all(args.recordings), reading.of_all(args.validate)
    of_file = config if args.config else None
    coupled = coupling.declared(args.mass_matrix, of_file, reading.axis, [*runs, *unseen])
    inertia, estimate = declared_inertia.inertia(args.inertia, of_file, runs, args.torque, coupled)
    signals, learner, effects = _settings(args, config, inertia, [*runs, *unseen], coupled)
    fit = Fit.of(runs, unseen, signals, learner, args.policy, effects, coupled, config.further_inputs)
    text = fit.text(estimate)
    if args.write is not None:
        of_body = config if coupled is None else _declared(config, inertia, coupled)
        _write(args, of_body.model_copy(update={"inputs": reading.description.inputs}), sequence(runs), fit)
        text += f"\n\nwritten to {args.write}; `incsvr serve --config {args.write}` learns on with it"
    result = fit.to_dict() | declared_inertia.told(estimate, fit.closed_loop, fit.remarks)
    if reading.axis != YAW:
        result |= {"axis": reading.axis.name, "remarks": [said(reading.axis, each) for each in result["remarks"]]}
    return result, text


@dataclass(frozen=True, slots=True)
class Fit:
    """What the online loop made of recordings.

    Attributes:
        name: the recordings, joined.
        signals, learner: the settings in force.
        samples: how many damping samples the recordings gave.
        rejected: messages of all recordings refused, by reason.
        remarks: sentences about what was left out.
        iterations: one for each full batch.
        errors: on the unseen recordings after each iteration [N m], None before anything is learned; empty where none
            were given.
        validated_on: the unseen recordings.
        free_run_rmse: of the final model on each unseen run from its first yaw rate [rad/s]; None where it runs away.
        effects: names of the traced effects in force.
        put_aside: batches that were not learned, because a check said that they are wrong.
        closed_loop: whether the torque answers the yaw rate that the water makes.
        others: what the other velocities of the body are to it.
    """

    name: str
    signals: SignalSettings
    learner: Settings
    samples: int
    rejected: Mapping[str, int]
    remarks: Sequence[str]
    iterations: Sequence[Iteration]
    errors: Sequence[Errors | None]
    validated_on: str
    free_run_rmse: float | None
    effects: tuple[str, ...] = ()
    put_aside: int = 0
    closed_loop: bool = False
    others: Told = coupling.NOTHING

    @staticmethod
    def of(
        runs: Sequence[Recording],
        unseen: Sequence[Recording],
        signals: SignalSettings,
        learner: Settings | None,
        policy: str | None = None,
        effects: TracedEffects | None = None,
        coupled: Coupled | None = None,
        inputs: tuple[str, ...] = (),
    ) -> Fit:
        """Learns from `runs`, one after the other; without `learner` the paper's settings scaled to the vehicle.

        With traced effects, or in a body whose mass matrix is declared, the samples are freed of what these take, and
        the free runs hold it. `inputs` are the further velocities that damping is learned over.
        """
        joined, compensation = sequence(runs), None if effects is None else effects.compensation
        samples, rejected = samples_of(joined, signals, compensation, coupled, inputs)
        chosen: dict[str, Any] = {} if policy is None else {"policy": policy}
        chosen |= {"own": joined.axis.rate, "others": inputs} if inputs else {}
        settings = learner_for(samples, **chosen) if learner is None else Settings(**asdict(learner) | chosen)
        if len(samples) < settings.batch:
            raise BadInput(
                f"{joined.name}: {len(samples)} damping samples, but one batch needs {settings.batch}; give more or "
                f"longer recordings (a sample every {signals.sample_period:g} s)"
            )
        iterations: list[Iteration] = []
        errors: list[Errors | None] = []
        verdicts: list[Verdict] = []
        validation, more = (
            samples_of(sequence(unseen), signals, compensation, coupled, inputs) if unseen else (Samples.empty(), {})
        )
        vehicle = Vehicle(signals.inertia, settings.rate_range, signals.smoothing, believed=learner is not None)
        with progress("learning", len(samples) // settings.batch) as advance:
            for verdict, iteration in guarded.follow(settings, vehicle, samples):
                verdicts.append(verdict)
                if iteration is not None:
                    iterations.append(iteration)
                    if unseen:
                        errors.append(Errors.of(iteration.model, validation) if iteration.model.is_trained else None)
                advance()
        _refuse(joined.name, verdicts)
        model = iterations[-1].model
        undriven = Samples.concatenate(iteration.undriven for iteration in iterations)
        excitation = Excitation.of(samples.take(slice(0, len(iterations) * settings.batch)), undriven)
        foreign = None if model.is_trained else foreign_inertia(runs, samples, signals)
        if foreign is not None:
            raise BadInput(f"{joined.name}: {foreign}")
        idle = not joined.streams()[TORQUE][1].any()
        little = idle or 2 * excitation.driven < settings.batch
        if little or not model.is_trained:
            undriven_at_all = Excitation(0, excitation.samples, excitation.fastest, None)
            made = (undriven_at_all if idle else excitation).sentence
            pushed = None if idle or coupled is not None else coupling.decoupled(joined, samples, signals)
            besides = "" if pushed is None else f"; or other velocities made it: {pushed}; {coupling.CURE}"
            doubted = next((each.findings[0].sentence for each in verdicts if each.findings), None)
            why = f"too little motion to learn from: {made}; {MANOEUVRE}"
            if doubted is not None and not little:
                why = f"nothing is left to learn from: {doubted}"
            raise BadInput(f"{joined.name}: {why}{besides}")
        if compensation is None:
            tests = [
                (motion if coupled is None else motion.among(coupled, one.streams(), signals.smoothing), one.streams())
                for one in unseen
                for motion in motions(one.streams(), signals.longest_pause)
            ]
            if inputs:
                free_run = over_several(tests, signals.inertia, model)
            else:
                free_run = free_run_rmse(
                    [motion for motion, _ in tests], signals.inertia, lambda rate: model.predict(rate).damping
                )
        elif inputs:
            raise BadInput(EFFECTS_OVER_ONE)
        else:
            streams = [wanted_streams(one, signals, True) for one in unseen]
            if coupled is not None:
                streams = [dict(freed(coupled, each, signals.smoothing)[0]) for each in streams]
            free_run = traced_free_run_rmse(
                streams, signals.longest_pause, compensation, lambda rate: model.predict(rate).damping
            )
        by_itself = not inputs or coupled is not None
        others = Told.of(coupled, joined, samples, signals) if by_itself else coupling.NOTHING
        said = [*remarks([*runs, *unseen], samples, signals), *others.remarks, *told(verdicts)]
        said += effects.warnings if effects else ()
        quick = unresolved(samples, signals.smoothing)
        if quick is not None:
            said.append(f"{quick.sentence}; {quick.cure(signals)}")
        if excitation.little:
            said.append(f"little excitation: {excitation.sentence}; {MANOEUVRE}")
        name = sequence(unseen).name if unseen else ""
        return Fit(
            joined.name,
            signals,
            settings,
            len(samples),
            Counter(rejected) + Counter(more),
            said,
            iterations,
            errors,
            name,
            free_run,
            () if compensation is None else compensation.names,
            len(verdicts) - len(iterations),
            torque_answers(undriven),
            others,
        )

    def to_dict(self) -> dict[str, Any]:
        """The contract's form, and what explains it."""
        model = self.iterations[-1].model
        rates = np.linspace(*(model.trained_range or (0.0, 0.0)), CURVE)
        curve = model.predict(rates)
        final = self.errors[-1] if self.errors else None
        last = None if final is None else asdict(final) | {"free_run_rmse": self.free_run_rmse}
        return {
            "iterations": len(self.iterations),
            "validation": last,
            "support_vectors": int(model.support_rate.size),
            "inertia": self.signals.inertia,
            "samples": self.samples,
            "put_aside": self.put_aside,
            "rejected": dict(self.rejected),
            "remarks": list(self.remarks),
            "curve": {
                "rate": rates.tolist(),
                "damping": curve.damping.tolist(),
                "sigma": curve.curve_sigma.tolist(),
            },
            "coefficients": {name: value._asdict() for name, value in coefficients(model).items()},
            "effects": list(self.effects),
            "validation_per_iteration": [None if errors is None else asdict(errors) for errors in self.errors],
            "progressive_mae": [iteration.progressive_mae for iteration in self.iterations],
            "trained_range": list(model.trained_range or ()),
            "settings": {"signals": asdict(self.signals), "learner": asdict(self.learner)},
            **self.others.to_dict(),
        }

    def text(self, estimate: InertiaEstimate | None) -> str:
        """The same for people."""
        source = (
            ""
            if estimate is None
            else f"{declared_inertia.doubt(estimate, self.closed_loop)}, estimated by output error"
        )
        signals, learner = self.signals, self.learner
        left = self.samples - (len(self.iterations) + self.put_aside) * learner.batch
        lines = [
            f"recordings  {self.name}: {self.samples} samples, {len(self.iterations)} batches of {learner.batch}, "
            f"{left} left over" + f", {self.put_aside} batches put aside" * bool(self.put_aside),
            f"vehicle     I = {signals.inertia:.4g} kg m²{source}; |r| ≤ {learner.rate_range[1]:.3g} rad/s",
            f"signals     a sample every {signals.sample_period:.3g} s, smoothed over {signals.smoothing:.3g} s",
            f"learner     policy {learner.policy}, γ = {learner.gamma:.3g} s²/rad², C = {learner.C:.3g} N m, "
            f"ε = {learner.epsilon:.2g} N m",
            *([f"inputs      {', '.join(('yaw_rate', *learner.others))}"] if learner.others else []),
            *([f"effects     {', '.join(self.effects)}"] if self.effects else []),
            *([f"remark      {declared_inertia.LIMITS}"] if estimate else []),
            *([f"remark      {declared_inertia.CLOSED}"] if estimate and self.closed_loop else []),
            *(f"remark      {remark}" for remark in self.remarks),
            *(f"refused     {count} messages: {reason}" for reason, count in self.rejected.items()),
            "",
            "iteration   until s   vectors   batch, before learning it" + ("   unseen runs" * bool(self.errors)),
            "                                MAE N m" + "                     MAE, RMSE N m" * bool(self.errors),
        ]
        for k, iteration in enumerate(self.iterations):
            before = "–" if iteration.progressive_mae is None else f"{iteration.progressive_mae:.3g}"
            errors = self.errors[k] if self.errors else None
            after = "" if errors is None else f"{errors.mae:.3g}, {errors.rmse:.3g}"
            size = iteration.model.support_rate.size
            lines.append(
                f"{iteration.number:9d} {iteration.time_span[1]:9.1f} {size:9d}   {before:<25s}   {after}".rstrip()
            )
        final = self.errors[-1] if self.errors else None
        if final is not None:
            ran = "runs away" if self.free_run_rmse is None else f"RMSE {self.free_run_rmse:.4f} rad/s"
            lines += [
                "",
                f"on {self.validated_on}: MAE {final.mae:.3g} N m, RMSE {final.rmse:.3g} N m; free run {ran}",
            ]
        return "\n".join(lines)


def _write(args: argparse.Namespace, config: Config, recording: Recording, fit: Fit) -> None:
    """What is in force, as a configuration: what was configured as it is, else scaled to the recordings."""
    update = {"effects": args.effects} if args.effects else {}
    if recording.axis.name != config.vehicle.axis:
        vehicle = config.vehicle.model_copy(update={"axis": recording.axis.name})
        config = config.model_copy(update={"vehicle": vehicle})
    if args.config:
        vehicle = config.vehicle.model_copy(update={"inertia": fit.signals.inertia})
        signals = config.signals.model_copy(update={"torque": fit.signals.torque})
        learner = config.learner.model_copy(update={"policy": fit.learner.policy})
        config = config.model_copy(update={"vehicle": vehicle, "signals": signals, "learner": learner})
    else:
        config = written.scaled(config, recording, fit.signals, fit.learner)
    written.write(
        args.write, config.model_copy(update=update), f"# By `incsvr fit` on {fit.name}, {fit.samples} samples.\n"
    )


def _refuse(name: str, verdicts: Sequence[Verdict]) -> None:
    """Refuse recordings of which most is wrong from beginning to end: no curve that is learned of them is right."""
    aside = [verdict for verdict in verdicts if not verdict.learn]
    if 2 * len(aside) > len(verdicts) and sum(verdict.learn for verdict in verdicts) < YOUNG:
        raise BadInput(f"{name}: {aside[0].findings[0].sentence}")


def _settings(
    args: argparse.Namespace,
    config: Config,
    inertia: float,
    recordings: Sequence[Recording],
    coupled: Coupled | None,
) -> tuple[SignalSettings, Settings | None, TracedEffects | None]:
    """As they are configured; where nothing is, such as suit the recordings."""
    streams = () if coupled is None else coupled.streams
    if args.config:
        wanted = _declared(config, inertia, coupled)
        if args.effects:
            wanted = wanted.model_copy(update={"effects": args.effects})
        configured_signals = wanted.signal_settings()
        if args.torque is not None:
            configured_signals = replace(configured_signals, torque=args.torque)
        return _waiting(configured_signals, streams), wanted.learner_settings(), configured(wanted)
    signals = signals_for(recordings[: len(args.recordings)], inertia, recordings[0].axis.fastest, args.torque)
    if args.effects is None:
        return _waiting(signals, streams), None, None
    common = tuple(name for name in recordings[0].channels if all(name in run.channels for run in recordings))
    effects = read_effects(args.effects, inertia, common, coupled)
    return _waiting(replace(signals, channels=effects.compensation.reads(common)), streams), None, effects


def _declared(config: Config, inertia: float, coupled: Coupled | None) -> Config:
    """The configuration of a vehicle with this inertia [kg m²], or in this body."""
    mass = None if coupled is None else tuple(coupled.mass.ravel().tolist())
    vehicle = config.vehicle.model_copy(update={"inertia": inertia, "mass_matrix": mass})
    return config.model_copy(update={"vehicle": vehicle})


def _waiting(signals: SignalSettings, streams: Sequence[str]) -> SignalSettings:
    """The settings of samples that wait for these streams, too."""
    return replace(signals, channels=tuple(dict.fromkeys((*signals.channels, *streams))))
