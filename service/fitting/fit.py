"""`fit`: the online loop over recordings, with the errors of every iteration on unseen ones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from incsvr.checks import verdict_sentences as in_sentences
from incsvr.forecasting.over_recordings import FitPictures, FreeRunErrors, rmse
from incsvr.learning.coefficients import NORMAL_95_DEVIATIONS, Interval, coefficients, negative_drag
from incsvr.learning.excitation import EXCITING_MANOEUVRE, Excitation, torque_answers
from incsvr.learning.model import Model
from incsvr.learning.prediction import Prediction
from incsvr.learning.score import Residual, Score
from incsvr.model.inertia import InertiaEstimate
from incsvr.numerics import root_mean_square
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.axis_words import in_words_of
from incsvr.plant.mass_and_coriolis import inertia_in_force
from incsvr.plant.words import words_of
from incsvr.signals import TORQUE, SignalSettings
from incsvr.signals.samples import Samples
from service.cli.extras import plots
from service.cli.next_command import AXIS_FLAGS, WRITTEN, with_next
from service.config.configuration import Config
from service.fitting import declared as of_inertia
from service.fitting.declaration import Declaration, judge_declaration
from service.fitting.declared import Declared
from service.fitting.each_log import refuse_idle, refuse_odd
from service.fitting.fit_text import text
from service.fitting.good_enough import (
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
from service.fitting.log import sources
from service.fitting.other_velocities import NO_OTHER_VELOCITIES, OtherVelocities
from service.fitting.request import Request, read_each
from service.fitting.results import frame
from service.fitting.settings import settings
from service.fitting.spoken import in_python
from service.fitting.terms import Terms
from service.fitting.training import Training, best_training
from service.fitting.written import Destination, base, leave
from service.recordings.log_refusals import beside_assumptions, notes_of, refuse_twice
from service.recordings.reading import Reading
from service.recordings.recording import Recording, sequence
from service.recordings.samples_from_recording import Errors, remarks

TAKES = ("vehicle", "signals", "learner", "inputs")
"""The values of the configuration that `fit` uses."""
CURVE_RATES = 101
"""Rates of the trained range at which the curve is told."""


@dataclass(frozen=True, slots=True, repr=False)
class Fit:
    """The result of the online loop over recordings; `str` is the text that the command prints.

    Attributes:
        joined: the recordings, one after the other.
        training: samples, settings in force, iterations, errors.
        terms: what all attempts had in common.
        remarks: sentences about what was left out.
        validated_on: the unseen recordings.
        free_run_rmse: of the final model on each unseen run from its first yaw rate [rad/s]; None where it runs away.
        pictures: for a report.
        others: what the other velocities of the body are to it.
        inertia: in force: the declared one, or the traced one where that is among the effects [kg m²].
        axis: the one whose damping is learned, of whose quantities the sentences speak.
        effort_rms: the root mean square torque of the unseen recordings [N m]; 0 where none were given.
        request, config, reading: what was asked, the configuration in force, and how the logs were read.
        estimate: of the inertia, where it was estimated.
    """

    joined: Recording
    training: Training
    terms: Terms
    remarks: Sequence[str]
    validated_on: str
    free_run_rmse: float | None
    pictures: FitPictures
    others: OtherVelocities = NO_OTHER_VELOCITIES
    inertia: float = 0.0
    axis: Axis = YAW
    effort_rms: float = 0.0
    request: Request = field(default_factory=lambda: Request(()))
    config: Config = field(default_factory=Config)
    reading: Reading = field(default_factory=Reading)
    estimate: InertiaEstimate | None = None

    @staticmethod
    def of(
        runs: Sequence[Recording],
        unseen: Sequence[Recording],
        signals: SignalSettings,
        terms: Terms | None = None,
        declaration: Declaration | None = None,
    ) -> Fit:
        """Learns from `runs`, one after the other. Other signal settings that are better come into force, but for
        those that a person set.

        With traced effects, or in a body whose mass matrix is declared, the samples are freed of what these take, and
        the free runs hold it.

        Args:
            terms: without them the paper's settings are scaled to the vehicle.
            declaration: what the motion says of the declared inertia and the torque.
        """
        terms = terms or Terms(axis=runs[0].axis)
        declaration = declaration or Declaration(list(runs), list(unseen))
        joined, effects, coupled = sequence(runs), terms.effects, terms.coupled
        training = best_training(runs, unseen, signals, terms, declaration)
        signals, samples, model = training.signals, training.samples, training.model
        pictured = terms.free_runs(unseen or runs, signals, model)
        by_itself = not terms.inputs or coupled is not None
        others = OtherVelocities.of(coupled, joined, samples, signals) if by_itself else NO_OTHER_VELOCITIES
        sentences = [*declaration.sentences, *remarks([*runs, *unseen], signals), *others.remarks]
        sentences += [*in_sentences(training.verdicts), *(effects.warnings if effects else ()), *training.said]
        return Fit(
            joined,
            training,
            terms,
            [*sentences, *_excitation_remark(training.excitation, joined.axis)],
            sequence(unseen).name if unseen else "",
            rmse(pictured) if unseen else None,
            FitPictures(model, samples, pictured, sequence(unseen or runs).name, bool(unseen)),
            others,
            inertia_in_force(signals.inertia, () if effects is None else effects.findings),
            joined.axis,
            root_mean_square(sequence(unseen).streams()[TORQUE][1]) if unseen else 0.0,
        )

    @property
    def name(self) -> str:
        """The recordings, joined."""
        return self.joined.name

    @property
    def model(self) -> Model:
        """The final one."""
        return self.training.model

    @property
    def put_aside(self) -> int:
        """Batches that were not learned, because a check said that they are wrong."""
        return len(self.training.verdicts) - len(self.training.iterations)

    @property
    def closed_loop(self) -> bool:
        """Whether the torque answers the yaw rate that the water makes."""
        return torque_answers(self.training.undriven)

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the traced effects in force."""
        return () if self.terms.compensation is None else self.terms.compensation.names

    def predict(self, rate: ArrayLike) -> Prediction:
        """Damping, sigma, doubt and whether it is extrapolated at (n,) rates, or one [rad/s].

        Raises:
            BadInput: a rate is not finite.
        """
        return self.model.predict(rate)

    def score(self, log: Any) -> Score:
        """The errors on a log, or several.

        Raises:
            BadInput: it cannot be read, or gives no sample.
        """
        recordings, samples = self._samples(log)
        errors = Errors.of(self.model, samples)
        free_run = self.terms.free_run(recordings, self.training.signals, self.model)
        return Score(errors.mae, errors.rmse, free_run, len(samples))

    def residual(self, log: Any) -> Residual:
        """What the model leaves of the damping samples of a log, or several, one after the other.

        Raises:
            BadInput: it cannot be read, or gives no sample.
        """
        _, samples = self._samples(log)
        return Residual(samples.time, samples.yaw_rate, samples.damping - self.model.at(samples).damping)

    def _samples(self, log: Any) -> tuple[list[Recording], Samples]:
        with in_python():
            recordings = read_each(self.reading.whole, sources("log", log))
            return recordings, self.terms.samples(sequence(recordings), self.training.signals)[0]

    def plot(self) -> Any:
        """The damping curve beside its samples, as a figure of matplotlib."""
        return plots().of_fit(self.pictures, self.axis)

    def to_frame(self) -> Any:
        """The damping curve as a DataFrame of pandas: rate, damping, sigma of a sample about it and its own doubt."""
        return frame(self.to_dict()["curve"])

    def __repr__(self) -> str:
        return with_next(text(self), *self.next)

    @property
    def next(self) -> tuple[str | None, str]:
        """The command that follows, if one does, and what it does."""
        request = self.request
        if request.effects is not None:
            more = ("--effects", str(request.effects), "--write", WRITTEN)
            return request.following("fit", AXIS_FLAGS, *more), "writes it down for `incsvr serve`"
        return request.following("trace", AXIS_FLAGS), "finds the effects that this model lacks"

    def write(
        self, path: str | Path, *, name: str | None = None, state: str | Path | None = None, force: bool = False
    ) -> str:
        """Writes a configuration from which `incsvr serve` continues, and the state of the learner; what was written.

        Args:
            path: the configuration; in a file that is there only fitted values change.
            name: of the vehicle in it; its keys then begin with `name/axis`.
            state: directory of the state; without it as the configuration has it.
            force: replaces a state that is there.

        Raises:
            BadInput: they cannot be written.
        """
        to = Destination(Path(path), name, None if state is None else Path(state), force)
        with in_python():
            base(to, self.request)
            return leave(self, to)

    @property
    def free_run(self) -> FreeRunErrors:
        """The errors of free runs over the unseen recordings, or over the learned ones where there are none."""
        return FreeRunErrors.of(self.pictures.free_runs)

    @property
    def uses(self) -> tuple[Use, ...]:
        """What the curve is good enough for."""
        words, run, final = (
            words_of(self.axis),
            self.free_run,
            self.training.errors[-1] if self.training.errors else None,
        )
        gyro = use_without_gyro(words)
        if final is None:
            why = "these data were learned; validate with a log that was not"
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
        model = self.model
        return model.predict(np.linspace(*(model.trained_range or (0.0, 0.0)), CURVE_RATES))

    @property
    def coefficients(self) -> dict[str, Interval]:
        """N_r and N_{r|r|} of the final model's curve."""
        return coefficients(self.model)

    @property
    def coefficient_notes(self) -> list[str]:
        """A sentence on each coefficient whose interval holds a negative drag."""
        words = words_of(self.axis)
        named = zip((words.linear, words.quadratic), self.coefficients.values(), strict=True)
        notes = (negative_drag(name, value.low, value.high) for name, value in named)
        return [note for note in notes if note is not None]

    def to_dict(self) -> dict[str, Any]:
        """The contract's form, and what explains it."""
        model = self.model
        rates = np.linspace(*(model.trained_range or (0.0, 0.0)), CURVE_RATES)
        curve = self.to_curve()
        final = self.training.errors[-1] if self.training.errors else None
        last = None if final is None else asdict(final) | {"free_run_rmse": self.free_run_rmse}
        found = {
            "iterations": len(self.training.iterations),
            "validation": last,
            "support_vectors": int(model.support_rate.size),
            "declared": {"inertia": self.training.signals.inertia},
            "inertia": self.inertia,
            "samples": len(self.training.samples),
            "put_aside": self.put_aside,
            "rejected": dict(self.training.rejected),
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
            "validation_per_iteration": [None if errors is None else asdict(errors) for errors in self.training.errors],
            "progressive_mae": [iteration.progressive_mae for iteration in self.training.iterations],
            "free_run": {"where": self.pictures.where, "unseen": self.pictures.unseen, **asdict(self.free_run)},
            "good_enough": good_enough(self.uses),
            "trained_range": list(model.trained_range or ()),
            "settings": {"signals": asdict(self.training.signals), "learner": asdict(self.training.settings)},
            **self.others.to_dict(),
            "next": self.next[0],
            **of_inertia.estimate_in_result(self.estimate, self.closed_loop),
        }
        return found | ({} if self.axis == YAW else {"axis": self.axis.name})


def fit(request: Request, config: Config | None = None) -> Fit:
    """Learns the damping of one axis.

    Args:
        request: the logs, and what is said of them.
        config: in place of that of the request's file.

    Raises:
        BadInput: the logs, or what is said of them, cannot be used; one sentence with the cure.
    """
    config = request.configured(TAKES, config)
    reading = request.reading(config)
    runs, unseen = request.read(reading)
    with beside_assumptions(notes_of([*runs, *unseen])):
        refuse_twice([*runs, *unseen])
        if any(np.nan_to_num(run.effort).any() for run in runs):  # of a vehicle that was carried: what to drive, below
            refuse_idle([*runs, *unseen], [reading.axis])
        if len(runs) + len(unseen) > 1:
            refuse_odd([*runs, *unseen], [reading.axis], request.assume_sign)
        declared = Declared.of(request, config, reading.axis, runs, [*runs, *unseen]).as_written
        declaration = None
        if declared.coupled is None and request.effects is None:
            said = declared.inertia, declared.torque, request.assume_sign
            declaration = judge_declaration(runs, unseen, *said)
            runs, unseen = declaration.runs, declaration.unseen
        found = Fit.of(runs, unseen, *settings(request, config, declared, runs, unseen), declaration)
    of_body = config if declared.coupled is None else declared.in_force(config)
    of_body = of_body.model_copy(update={"inputs": reading.description.inputs})
    if declared.estimate is not None:
        limits = of_inertia.estimate_remarks(declared.estimate, found.closed_loop, words_of(found.axis))
        found = replace(found, remarks=[*limits, *found.remarks])
    return replace(found, request=request, config=of_body, reading=reading, estimate=declared.estimate)


def _excitation_remark(excitation: Excitation, axis: Axis) -> list[str]:
    """What is to be known of samples few of which are evidence, and what to drive; empty where enough are."""
    if not excitation.little:
        return []
    return [in_words_of(axis, f"little excitation: {excitation.sentence}; {EXCITING_MANOEUVRE}")]
