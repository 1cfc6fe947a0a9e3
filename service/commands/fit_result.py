"""The result of the online loop over recordings: the iterations, and the errors of each on unseen ones."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from incsvr.checks import Verdict
from incsvr.checks import verdict_sentences as in_sentences
from incsvr.checks.resolution import resolution_fault
from incsvr.errors import BadInput
from incsvr.forecasting.over_recordings import FitPictures, FreeRunErrors, rmse
from incsvr.learning.checked_learner import Guarded
from incsvr.learning.coefficients import NORMAL_95_DEVIATIONS, Interval, coefficients, negative_drag
from incsvr.learning.excitation import EXCITING_MANOEUVRE, Excitation, torque_answers
from incsvr.learning.learner import Iteration, Settings
from incsvr.learning.prediction import Prediction
from incsvr.numerics import root_mean_square
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.axis_words import in_words_of
from incsvr.plant.body import Coupled
from incsvr.plant.mass_and_coriolis import inertia_in_force
from incsvr.plant.words import words_of
from incsvr.signals import TORQUE, SignalSettings
from incsvr.signals.samples import Samples
from service.cli.progress import progress
from service.commands.declaration import Cures, Declaration
from service.commands.fit_alternatives import alternative
from service.commands.fit_attempt import (
    TORQUE_KIND,
    HeldTooSeldom,
    Terms,
    of_a_command,
    refuse_unlearned,
    refuse_wrong,
    too_few,
)
from service.commands.good_enough import (
    MAX_MOTION_SHARE,
    MAX_TORQUE_SHARE,
    Use,
    closed_loop,
    feed_forward,
    good_enough,
    noticing,
    unknown,
    use_without_gyro,
    without_gyro,
)
from service.commands.other_velocities import NO_OTHER_VELOCITIES, OtherVelocities
from service.config.traced_effects import TracedEffects
from service.recordings.recording import Recording, sequence
from service.recordings.samples_from_recording import Errors, remarks

CURVE_RATES = 101
"""Rates of the trained range at which the curve is told."""


@dataclass(frozen=True, slots=True)
class Fit:
    """The result of the online loop over recordings.

    Attributes:
        name: the recordings, joined.
        signals, learner: the settings in force.
        samples: how many damping samples the recordings gave.
        rejected: messages of all recordings refused, by reason.
        remarks: sentences about what was left out.
        iterations: one for each full batch.
        guarded: the learner and its checks after the last one.
        errors: on the unseen recordings after each iteration [N m], None before anything is learned; empty where none
            were given.
        validated_on: the unseen recordings.
        free_run_rmse: of the final model on each unseen run from its first yaw rate [rad/s]; None where it runs away.
        pictures: for a report.
        effects: names of the traced effects in force.
        put_aside: batches that were not learned, because a check said that they are wrong.
        closed_loop: whether the torque answers the yaw rate that the water makes.
        others: what the other velocities of the body are to it.
        inertia: in force: the declared one, or the traced one where that is among the effects [kg m²].
        axis: the one whose damping is learned, of whose quantities the sentences speak.
        effort_rms: the root mean square torque of the unseen recordings [N m]; 0 where none were given.
    """

    name: str
    signals: SignalSettings
    learner: Settings
    samples: int
    rejected: Mapping[str, int]
    remarks: Sequence[str]
    iterations: Sequence[Iteration]
    guarded: Guarded
    errors: Sequence[Errors | None]
    validated_on: str
    free_run_rmse: float | None
    pictures: FitPictures
    effects: tuple[str, ...] = ()
    put_aside: int = 0
    closed_loop: bool = False
    others: OtherVelocities = NO_OTHER_VELOCITIES
    inertia: float = 0.0
    axis: Axis = YAW
    effort_rms: float = 0.0

    @staticmethod
    def of(
        runs: Sequence[Recording],
        unseen: Sequence[Recording],
        signals: SignalSettings,
        learner: Settings | None,
        chosen: Mapping[str, Any] | None = None,
        effects: TracedEffects | None = None,
        coupled: Coupled | None = None,
        inputs: tuple[str, ...] = (),
        declaration: Declaration | None = None,
        sign_known: bool = False,
        by_person: frozenset[str] = frozenset(),
    ) -> Fit:
        """Learns from `runs`, one after the other; without `learner` the paper's settings scaled to the vehicle, with
        what is `chosen` of them. Other signal settings that are better come into force, but for those set `by_person`.

        With traced effects, or in a body whose mass matrix is declared, the samples are freed of what these take, and
        the free runs hold it. `inputs` are the further velocities that damping is learned over; `declaration` is what
        the motion says of the declared inertia and the torque, whose sign may be known.
        """
        terms = Terms(learner, chosen or {}, effects, coupled, inputs, sign_known, runs[0].axis, by_person)
        declaration = declaration or Declaration(list(runs), list(unseen))
        joined = sequence(runs)
        signals, training, said = _best_training(runs, unseen, signals, terms, declaration)
        samples, iterations = training.samples, training.iterations
        model, excitation = iterations[-1].model, training.excitation
        pictured = terms.free_runs(unseen or runs, signals, model)
        by_itself = not inputs or coupled is not None
        others = OtherVelocities.of(coupled, joined, samples, signals) if by_itself else NO_OTHER_VELOCITIES
        sentences = [*declaration.sentences, *remarks([*runs, *unseen], signals), *others.remarks]
        sentences += [*in_sentences(training.verdicts), *(effects.warnings if effects else ())]
        return Fit(
            joined.name,
            signals,
            training.settings,
            len(samples),
            training.rejected,
            [*sentences, *said, *_excitation_remark(excitation, joined.axis)],
            iterations,
            training.guarded,
            training.errors,
            sequence(unseen).name if unseen else "",
            rmse(pictured) if unseen else None,
            FitPictures(model, samples, pictured, sequence(unseen or runs).name, bool(unseen)),
            () if terms.compensation is None else terms.compensation.names,
            len(training.verdicts) - len(iterations),
            torque_answers(training.undriven),
            others,
            inertia_in_force(signals.inertia, () if effects is None else effects.findings),
            joined.axis,
            root_mean_square(sequence(unseen).streams()[TORQUE][1]) if unseen else 0.0,
        )

    @property
    def free_run(self) -> FreeRunErrors:
        """The errors of free runs over the unseen recordings, or over the learned ones where there are none."""
        return FreeRunErrors.of(self.pictures.free_runs)

    @property
    def uses(self) -> tuple[Use, ...]:
        """What the curve is good enough for."""
        words, run, final = words_of(self.axis), self.free_run, self.errors[-1] if self.errors else None
        gyro = use_without_gyro(words)
        if final is None:
            why = "these data were learned; give a log that was not with --validate"
            judged = (unknown("feed-forward", MAX_TORQUE_SHARE, why), unknown(gyro, MAX_MOTION_SHARE, why))
        else:
            free = without_gyro(run.model, run.zero, run.hold, words)
            free = closed_loop(gyro, words) if self.closed_loop else free
            judged = (feed_forward(final.rmse, self.effort_rms, words), free)
        curve = self.to_curve()
        size = root_mean_square(curve.damping)
        # of two dives, each as uncertain as this one
        share = NORMAL_95_DEVIATIONS * math.sqrt(2.0) * root_mean_square(curve.doubt) / size if size > 0.0 else math.inf
        return (*judged, noticing(share, "damping"))

    def to_curve(self) -> Prediction:
        """The curve at rates spread over the trained range."""
        model = self.iterations[-1].model
        return model.predict(np.linspace(*(model.trained_range or (0.0, 0.0)), CURVE_RATES))

    @property
    def coefficients(self) -> dict[str, Interval]:
        """N_r and N_{r|r|} of the final model's curve."""
        return coefficients(self.iterations[-1].model)

    @property
    def coefficient_notes(self) -> list[str]:
        """A sentence on each coefficient whose interval holds a negative drag."""
        words = words_of(self.axis)
        named = zip((words.linear, words.quadratic), self.coefficients.values(), strict=True)
        notes = (negative_drag(name, value.low, value.high) for name, value in named)
        return [note for note in notes if note is not None]

    def to_dict(self) -> dict[str, Any]:
        """The contract's form, and what explains it."""
        model = self.iterations[-1].model
        rates = np.linspace(*(model.trained_range or (0.0, 0.0)), CURVE_RATES)
        curve = self.to_curve()
        final = self.errors[-1] if self.errors else None
        last = None if final is None else asdict(final) | {"free_run_rmse": self.free_run_rmse}
        return {
            "iterations": len(self.iterations),
            "validation": last,
            "support_vectors": int(model.support_rate.size),
            "declared": {"inertia": self.signals.inertia},
            "inertia": self.inertia,
            "samples": self.samples,
            "put_aside": self.put_aside,
            "rejected": dict(self.rejected),
            "remarks": list(self.remarks),
            "curve": {
                "rate": rates.tolist(),
                "damping": curve.damping.tolist(),
                "sigma": curve.sigma.tolist(),
                "doubt": curve.doubt.tolist(),
            },
            "coefficients": {name: value._asdict() for name, value in self.coefficients.items()},
            "coefficient_notes": self.coefficient_notes,
            "effects": list(self.effects),
            "validation_per_iteration": [None if errors is None else asdict(errors) for errors in self.errors],
            "progressive_mae": [iteration.progressive_mae for iteration in self.iterations],
            "free_run": {"where": self.pictures.where, "unseen": self.pictures.unseen, **asdict(self.free_run)},
            "good_enough": good_enough(self.uses),
            "trained_range": list(model.trained_range or ()),
            "settings": {"signals": asdict(self.signals), "learner": asdict(self.learner)},
            **self.others.to_dict(),
        }


def _excitation_remark(excitation: Excitation, axis: Axis) -> list[str]:
    """What is to be known of samples few of which are evidence, and what to drive; empty where enough are."""
    if not excitation.little:
        return []
    return [in_words_of(axis, f"little excitation: {excitation.sentence}; {EXCITING_MANOEUVRE}")]


@dataclass(frozen=True, slots=True)
class _Training:
    """The course of the online loop: samples, settings, verdicts on the batches, iterations, errors of each."""

    samples: Samples
    settings: Settings
    rejected: Mapping[str, int]
    verdicts: Sequence[Verdict]
    iterations: Sequence[Iteration]
    guarded: Guarded
    errors: Sequence[Errors | None]

    @property
    def undriven(self) -> Samples:
        """The samples that are no evidence."""
        return Samples.concatenate(iteration.undriven for iteration in self.iterations)

    @property
    def excitation(self) -> Excitation:
        learned = self.samples.take(slice(0, len(self.iterations) * self.settings.batch))
        return Excitation.of(learned, self.undriven)


def _best_training(
    runs: Sequence[Recording],
    unseen: Sequence[Recording],
    signals: SignalSettings,
    terms: Terms,
    declaration: Declaration,
) -> tuple[SignalSettings, _Training, list[str]]:
    """The loop under these signal settings, or under others that are better, and the remarks on them.

    Raises:
        BadInput: too little can be learned.
    """
    said, in_force = list[str](), frozenset[str]()
    while True:
        try:
            training = _training(runs, unseen, signals, terms)
        except HeldTooSeldom as error:
            if TORQUE_KIND in terms.by_person | in_force:
                raise
            signals, in_force = error.measured, in_force | {TORQUE_KIND}
            said.append(error.because)
            continue
        _refuse(sequence(runs), training, signals, terms, declaration, Cures.of(runs[0]))
        quick = None if declaration.doubt is not None else resolution_fault(training.samples, signals.smoothing)
        if quick is None:
            return signals, training, said
        model = training.iterations[-1].model
        remark, best = alternative(quick, runs, unseen or runs, signals, terms, model, in_force)
        said += [] if remark is None else [remark]
        if best is None:
            return signals, training, said
        signals, in_force = best.signals, in_force | {best.setting}


def _refuse(
    joined: Recording,
    training: _Training,
    signals: SignalSettings,
    terms: Terms,
    declaration: Declaration,
    cures: Cures,
) -> None:
    """Refuses recordings that are wrong, or teach too little."""
    refuse_wrong(joined.name, training.verdicts, cures)
    refuse_unlearned(
        joined, training.samples, signals, training.iterations[-1].model, training.excitation, terms,
        training.verdicts, training.settings.batch, declaration.sign or declaration.doubt, cures,
    )  # fmt: skip


def _training(
    runs: Sequence[Recording], unseen: Sequence[Recording], signals: SignalSettings, terms: Terms
) -> _Training:
    """The loop over all full batches of the runs, with the error on the unseen ones after each iteration.

    Raises:
        BadInput: there is not one full batch.
    """
    joined = sequence(runs)
    try:
        samples, rejected = terms.samples(joined, signals)
    except BadInput as error:
        raise of_a_command(runs, signals, terms, 0, 1) or error from None
    settings = terms.settings(joined, samples)
    if len(samples) < settings.batch:
        raise too_few(runs, signals, terms, len(samples), settings.batch)
    validation, more = terms.samples(sequence(unseen), signals) if unseen else (Samples.empty(), {})
    errors: list[Errors | None] = []
    with progress("learning", len(samples) // settings.batch) as advance:

        def judge(iteration: Iteration | None) -> None:
            if iteration is not None and unseen:
                errors.append(Errors.of(iteration.model, validation) if iteration.model.is_trained else None)
            advance()

        verdicts, iterations, guarded = terms.learned(samples, signals, settings, judge)
    return _Training(samples, settings, Counter(rejected) + Counter(more), verdicts, iterations, guarded, errors)
