"""One repetition of the whole experiment: the baselines and the learners on T1 and T2, judged on V1 and V2."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from incsvr.learning.baselines import (
    AdaptiveIdentifier,
    Baseline,
    Data,
    LeastSquares,
    OfflineSVR,
    RecursiveLeastSquares,
)
from incsvr.learning.learner import Settings, start, step
from incsvr.learning.model import Model
from incsvr.samples import Array, Samples
from simulator import leng
from simulator.recordings import sequence

LEARNERS: Mapping[str, Settings] = {
    "paper": Settings(policy="paper"),
    "weighted": Settings(policy="weighted"),
    "paper, Eq. 8": Settings(policy="paper", solver="passes"),
}
"""The learners by name; the last is the paper's to the letter, and takes a hundred times as long."""
USUAL = ("paper", "weighted")

Row = tuple[float, float, float]
"""MAE [N m], RMSE [N m], support vectors (or coefficients)."""


@dataclass(frozen=True, slots=True)
class Repetition:
    """What one seed gave.

    Attributes:
        rows: (regressor, learner or "", validation run) → its row.
        curves: (learner, validation run) → MAE [N m] after every iteration of that experiment.
        old_model: learner → MAE [N m] on V2 of the model from the end of T1.
    """

    rows: dict[tuple[str, str, str], Row]
    curves: dict[tuple[str, str], list[float]]
    old_model: dict[str, float]


def repeat(seed: int, learners: Sequence[str] = USUAL) -> Repetition:
    """One repetition of the whole experiment with the baselines and these LEARNERS."""
    recordings = {name: leng.recording(name, seed) for name in leng.RUNS}
    samples = {name: leng.samples(recording) for name, recording in recordings.items()}
    rows: dict[tuple[str, str, str], Row] = {}

    def judge(name: str, learner: str, predict: Callable[[Array], Array], size: int, validation: str) -> None:
        rows[name, learner, validation] = (*_errors(predict, samples[validation]), float(size))

    def data(*runs: str) -> Data:
        streams = sequence([recordings[name] for name in runs]).streams()
        parts = Samples.concatenate([samples[name] for name in runs])
        return Data.of(parts, streams["yaw_rate"], streams["torque"])

    for name, training, validations in (("B1", "T1", ("V1", "V2")), ("B2", "T2", ("V2",))):
        svr = OfflineSVR.tuned(samples[training]).fit(data(training))
        for validation in validations:
            judge(name, "", svr.predict, svr.support_rate.size, validation)
    curves: dict[tuple[str, str], list[float]] = {}
    old_model: dict[str, float] = {}
    for learner in learners:
        models, errors = _learn(LEARNERS[learner], samples)
        for name, validation in (("IncSVR1", "V1"), ("IncSVR2", "V2")):
            model = models[validation]
            judge(name, learner, _damping(model), model.support_rate.size, validation)
            curves[learner, validation] = errors[validation]
        old_model[learner] = _errors(_damping(models["V1"]), samples["V2"])[0]
    methods: dict[str, Baseline] = {
        "least squares": LeastSquares(),
        "recursive least squares": RecursiveLeastSquares(),
        "adaptive identifier": AdaptiveIdentifier(inertia=leng.INERTIA, rate_scale=leng.MAX_RATE),
    }
    for name, method in methods.items():
        # Ordinary least squares is offline as B2 is; the other two go on from T1 to T2 as the learners do.
        second = data("T2") if name == "least squares" else data("T1", "T2")
        judge(name, "", method.fit(data("T1")).predict, 2, "V1")
        judge(name, "", method.fit(second).predict, 2, "V2")
    return Repetition(rows, curves, old_model)


def _learn(settings: Settings, samples: dict[str, Samples]) -> tuple[dict[str, Model], dict[str, list[float]]]:
    """The learner over T1 and on over T2: its model after each, and its MAE after every iteration."""
    state = start(settings)
    models, curves, offset = {}, {}, 0.0
    for training, validation in (("T1", "V1"), ("T2", "V2")):
        train, curve = samples[training], []
        for first in range(0, len(train) - settings.batch + 1, settings.batch):
            batch = train.take(slice(first, first + settings.batch))
            state, _ = step(settings, state, replace(batch, time=batch.time + offset))
            curve.append(_errors(_damping(state.model), samples[validation])[0])
        offset += float(train.time[-1]) + 10.0
        models[validation], curves[validation] = state.model, curve
    return models, curves


def _damping(model: Model) -> Callable[[Array], Array]:
    return lambda rate: model.predict(rate).damping


def _errors(predict: Callable[[Array], Array], samples: Samples) -> tuple[float, float]:
    """MAE and RMSE [N m]."""
    residual = predict(samples.yaw_rate) - samples.damping
    return float(np.mean(np.abs(residual))), float(np.sqrt(np.mean(residual**2)))


def repetitions(seeds: int, learners: Sequence[str] = USUAL) -> Iterator[Repetition]:
    """All repetitions, on all cores; each draws from its own seed alone, so who computes which makes no difference."""
    if seeds == 1:
        yield repeat(0, learners)
        return
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the workers are the parallel ones
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(seeds, os.cpu_count() or 1), mp_context=context) as pool:
        yield from pool.map(partial(repeat, learners=learners), range(seeds))
