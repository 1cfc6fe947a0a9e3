"""What the online loop makes of recordings: the iterations, and the errors of each on unseen ones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from incsvr.compensation import Compensation
from incsvr.errors import BadInput
from incsvr.learning import guarded
from incsvr.learning.coefficients import coefficients
from incsvr.learning.excitation import MANOEUVRE, Excitation, torque_answers
from incsvr.learning.learner import Iteration, Settings
from incsvr.learning.model import Model
from incsvr.learning.motion import free_run_rmse, motions
from incsvr.learning.resolution import unresolved
from incsvr.learning.several.free_run import free_run_rmse as over_several
from incsvr.plant.body import Coupled
from incsvr.samples import Samples
from incsvr.signals import TORQUE, SignalSettings
from incsvr.signals.checks import YOUNG, Vehicle, Verdict, told
from incsvr.signals.coupled import freed
from incsvr.traced_motion import traced_free_run_rmse
from service.effects import TracedEffects
from service.progress import progress
from simulator import coupling
from simulator.coupling import Told
from simulator.online import Errors, foreign_inertia, learner_for, remarks, samples_of, wanted_streams
from simulator.recordings import Recording, sequence

EFFECTS_OVER_ONE = (
    "with traced effects damping is learned over one velocity, over which they were traced; leave out --effects, or "
    "the further inputs"
)
CURVE = 101
"""Rates of the trained range at which the curve is told."""


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
        _refuse_unlearned(runs, joined, samples, signals, model, excitation, coupled, verdicts, settings.batch)
        free_run = _free_run(unseen, signals, model, compensation, coupled, inputs)
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


def _refuse(name: str, verdicts: Sequence[Verdict]) -> None:
    """Refuse recordings of which most is wrong from beginning to end: no curve that is learned of them is right."""
    aside = [verdict for verdict in verdicts if not verdict.learn]
    if 2 * len(aside) > len(verdicts) and sum(verdict.learn for verdict in verdicts) < YOUNG:
        raise BadInput(f"{name}: {aside[0].findings[0].sentence}")


def _refuse_unlearned(
    runs: Sequence[Recording],
    joined: Recording,
    samples: Samples,
    signals: SignalSettings,
    model: Model,
    excitation: Excitation,
    coupled: Coupled | None,
    verdicts: Sequence[Verdict],
    batch: int,
) -> None:
    """Refuse recordings from which too little can be learned, with why, and what to drive."""
    foreign = None if model.is_trained else foreign_inertia(runs, samples, signals)
    if foreign is not None:
        raise BadInput(f"{joined.name}: {foreign}")
    idle = not joined.streams()[TORQUE][1].any()
    little = idle or 2 * excitation.driven < batch
    if model.is_trained and not little:
        return
    undriven_at_all = Excitation(0, excitation.samples, excitation.fastest, None)
    made = (undriven_at_all if idle else excitation).sentence
    pushed = None if idle or coupled is not None else coupling.decoupled(joined, samples, signals)
    besides = "" if pushed is None else f"; or other velocities made it: {pushed}; {coupling.CURE}"
    doubted = next((each.findings[0].sentence for each in verdicts if each.findings), None)
    why = f"too little motion to learn from: {made}; {MANOEUVRE}"
    if doubted is not None and not little:
        why = f"nothing is left to learn from: {doubted}"
    raise BadInput(f"{joined.name}: {why}{besides}")


def _free_run(
    unseen: Sequence[Recording],
    signals: SignalSettings,
    model: Model,
    compensation: Compensation | None,
    coupled: Coupled | None,
    inputs: tuple[str, ...],
) -> float | None:
    """The root mean square error of free runs over the unseen recordings [rad/s]; None where the model runs away."""
    if compensation is not None and inputs:
        raise BadInput(EFFECTS_OVER_ONE)
    if compensation is not None:
        streams = [wanted_streams(one, signals, True) for one in unseen]
        if coupled is not None:
            streams = [dict(freed(coupled, each, signals.smoothing)[0]) for each in streams]
        return traced_free_run_rmse(
            streams, signals.longest_pause, compensation, lambda rate: model.predict(rate).damping
        )
    tests = [
        (motion if coupled is None else motion.among(coupled, one.streams(), signals.smoothing), one.streams())
        for one in unseen
        for motion in motions(one.streams(), signals.longest_pause)
    ]
    if inputs:
        return over_several(tests, signals.inertia, model)
    return free_run_rmse([motion for motion, _ in tests], signals.inertia, lambda rate: model.predict(rate).damping)
