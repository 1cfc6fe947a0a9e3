"""One repetition of the whole experiment: the baselines and the learners on T1 and T2, judged on V1 and V2.

One evaluator judges every row: the regressor's own sum f(r) at the validation run's samples, as in the paper. For the
SVRs that is Σ θⱼ κ(rⱼ, r), without the continuation beyond the learned rates that the service serves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.baselines import (
    AdaptiveIdentifier,
    Baseline,
    Data,
    LeastSquares,
    LeastSquaresSVR,
    NeuralNetwork,
    OfflineSVR,
    Predict,
    RecursiveLeastSquares,
    TotalLeastSquares,
)
from incsvr.learning.dual import solve
from incsvr.learning.iteration import Iteration
from incsvr.learning.kernel import rbf
from incsvr.learning.learner import Settings, start, step
from incsvr.learning.tuning import ranked, search
from incsvr.numerics import Array
from incsvr.signals.samples import Samples
from service.recordings.recording import sequence
from simulator import leng

LEARNERS: Mapping[str, Settings] = {
    "paper": Settings(policy="paper"),
    "weighted": Settings(policy="weighted"),
}
"""The learners by name."""
TUNED = "tuned as in IV-B"
TUNED_LAST = "tuned, last step"
AT_CONVERGENCE = "at convergence †"
BEFORE_CLEANING = "before clean-up"
EXPERIMENTS = (("1", "T1", "V1"), ("2", "T2", "V2"))
"""Number, training run and validation run."""

Row = tuple[float, float, float]
"""MAE [N m], RMSE [N m], support vectors (or coefficients)."""


@dataclass(frozen=True, slots=True)
class Repetition:
    """What one seed gave.

    Attributes:
        rows: (regressor, learner or "", validation run) → its row.
        curves: (learner, validation run) → MAE [N m] after every iteration of that experiment.
        untrained: validation run → MAE [N m] of the model that has learned nothing, f = 0.
        old_model: learner → MAE [N m] on V2 of the model from the end of T1.
        converged: (learner, validation run) → after how many iterations IV-C would stop.
        points: what was searched ("B1", "B2", TUNED, TUNED_LAST) → C [N m], ε [N m], γ [s²/rad²].
    """

    rows: dict[tuple[str, str, str], Row]
    curves: dict[tuple[str, str], list[float]]
    untrained: dict[str, float]
    old_model: dict[str, float]
    converged: dict[tuple[str, str], int]
    points: dict[str, tuple[float, float, float]]


def repeat(seed: int, whole: bool = True) -> Repetition:
    """One repetition of the whole experiment with the baselines and the LEARNERS.

    Args:
        whole: also the paper's learner with C, ε and γ searched on T1 (Section IV-B), and the baselines beside the
            offline SVR: ten seconds of a core.
    """
    recordings = {name: leng.recording(name, seed) for name in leng.RUNS}
    samples = {name: leng.samples(recording) for name, recording in recordings.items()}
    untrained = {name: float(np.mean(np.abs(samples[name].damping))) for name in ("V1", "V2")}
    done = Repetition({}, {}, untrained, {}, {}, {})

    def data(*runs: str) -> Data:
        streams = sequence([recordings[name] for name in runs]).streams()
        parts = Samples.concatenate([samples[name] for name in runs])
        return Data.of(parts, streams["yaw_rate"], streams["torque"])

    validated = {}
    for number, training, _ in EXPERIMENTS:
        svr = OfflineSVR.tuned(samples[training])
        validated[training] = svr.cross_validated(samples[training])
        done.points[f"B{number}"] = svr.C, svr.epsilon, svr.gamma
        curve = svr.fit(data(training))
        for validation in ("V1", "V2") if number == "1" else ("V2",):
            errors = _errors(curve, samples[validation])
            done.rows[f"B{number}", "", validation] = (*errors, float(curve.support_rate.size))
    for learner, settings in LEARNERS.items():
        _learned(done, learner, settings, samples, validated)
    if not whole:
        return done
    trials = list(search(samples["T1"], LEARNERS["paper"]))
    for name, chosen in ((TUNED, ranked(trials, "every")[0]), (TUNED_LAST, ranked(trials, "last")[0])):
        done.points[name] = chosen.point
        _learned(done, name, chosen.settings, samples, None)
    for name, (method, size) in _methods().items():
        # What goes sample by sample goes on from T1 to T2 as the learners do; the others are offline as B2 is.
        online = isinstance(method, RecursiveLeastSquares | AdaptiveIdentifier)
        for runs, validation in ((("T1",), "V1"), (("T1", "T2") if online else ("T2",), "V2")):
            given = data(*runs)
            predict = method.fit(given)
            done.rows[name, "", validation] = (
                *_errors(predict, samples[validation]),
                float(len(given.samples) if size is None else size),
            )
    return done


def _methods() -> Mapping[str, tuple[Baseline, int | None]]:
    """What else a user would take, and how many coefficients it has; None where every sample is one."""
    return {
        "least squares": (LeastSquares(), 2),
        "total least squares": (TotalLeastSquares(), 2),
        "recursive least squares": (RecursiveLeastSquares(), 2),
        "adaptive identifier": (AdaptiveIdentifier(inertia=leng.INERTIA, rate_scale=leng.MAX_RATE), 2),
        "neural network": (NeuralNetwork(), 3 * NeuralNetwork().hidden + 1),
        "least-squares SVR": (LeastSquaresSVR(), None),
    }


def _learned(
    done: Repetition,
    learner: str,
    settings: Settings,
    samples: Mapping[str, Samples],
    validated: Mapping[str, float] | None,
) -> None:
    """The learner over T1 and on over T2; its rows, its curves, and, where the offline SVR's cross-validated errors on
    T1 and T2 are given, when it would be stopped."""
    state, offset = start(settings), 0.0
    for number, training, validation in EXPERIMENTS:
        train, rows, iterations = samples[training], list[Row](), list[Iteration]()
        for first in range(0, len(train) - settings.batch + 1, settings.batch):
            batch = train.take(slice(first, first + settings.batch))
            state, iteration = step(settings, state, replace(batch, time=batch.time + offset))
            iterations.append(iteration)
            errors = _errors(state.model.evaluate, samples[validation])
            rows.append((*errors, float(state.model.support_rate.size)))
        offset += float(train.time[-1]) + 10.0
        name = f"IncSVR{number}"
        done.rows[name, learner, validation] = rows[-1]
        done.curves[learner, validation] = [row[0] for row in rows]
        if validation == "V1":
            done.old_model[learner] = _errors(state.model.evaluate, samples["V2"])[0]
        if validated is None:
            continue
        stop = stopped(np.array(done.curves[learner, validation]), validated[training])
        done.converged[learner, validation] = stop
        if learner == "paper":
            done.rows[name, AT_CONVERGENCE, validation] = rows[stop - 1]
            trained = [iteration for iteration in iterations if iteration.trained][-1]
            predict, vectors = _as_trained(settings, trained)
            done.rows[name, BEFORE_CLEANING, validation] = (*_errors(predict, samples[validation]), float(vectors))


def stopped(curve: Array, validated: float) -> int:
    """After how many iterations Section IV-C calls a learner converged.

    It does "where the difference between two consecutive updates is minimal and close to the cross-validation's value":
    no threshold is given, so the sum of the two distances is minimised.

    Args:
        curve: (n,) the error on the validation run after each iteration [N m], n ≥ 2.
        validated: the cross-validation's error on the training run [N m].
    """
    return int(np.argmin(np.abs(np.diff(curve)) + np.abs(curve[1:] - validated))) + 2


def _as_trained(settings: Settings, iteration: Iteration) -> tuple[Predict, int]:
    """What the paper's step solves, before outliers and the forgotten are taken out of it; its support vectors."""
    x, y = (
        np.concatenate([getattr(part, name) for part in (iteration.old, iteration.new)])
        for name in ("yaw_rate", "damping")
    )
    weight = solve(x, y, gamma=settings.gamma, C=settings.C, epsilon=settings.epsilon).weight
    return lambda rate: rbf(rate, x, settings.gamma) @ weight, int(np.count_nonzero(np.abs(weight) > 1e-9 * settings.C))


def _errors(predict: Predict, samples: Samples) -> tuple[float, float]:
    """MAE and RMSE [N m]."""
    residual = predict(samples.yaw_rate) - samples.damping
    return float(np.mean(np.abs(residual))), float(np.sqrt(np.mean(residual**2)))
