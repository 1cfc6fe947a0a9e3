"""A training step and a prediction beside their peers, on the simulated experiment, in one process and in turn.

Every step is timed from inclusion to certificate. scikit-learn's SVR then trains on exactly the samples that this step
trained on, and after some steps Eq. 8's passes too, so that all see the same problem at the same moment. Times are the
thread's on its processor: what else the machine does is not in them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import thread_time
from typing import Any

import numpy as np
from sklearn.svm import SVR

from benchmarks.paper.baselines import (
    AdaptiveIdentifier,
    Baseline,
    Data,
    LeastSquares,
    OfflineSVR,
    RecursiveLeastSquares,
)
from benchmarks.paper.repetition import LEARNERS
from incsvr.learning.dual import coordinate_descent
from incsvr.learning.learner import Iteration, Settings, start, step
from incsvr.learning.model import Model
from incsvr.signals import SignalSettings, Synchroniser
from incsvr.signals.samples import Samples
from simulator import leng

PASSES_GAP = 1e-2
"""Relative duality gap to which Eq. 8's passes run: they certify little there, and take thousands of passes."""
SIZES = (1, 100, 10_000)


def measure(seeds: int = 20, passes: int = 6, advance: Callable[[], None] = lambda: None) -> dict[str, Any]:
    """All figures of the learner.

    Args:
        seeds: repetitions of the experiment.
        passes: after how many steps of the first repetition Eq. 8's passes run: they take up to a second each.
        advance: called after each of the seeds + 1 parts.
    """
    parts = {policy: _Steps(settings) for policy, settings in LEARNERS.items()}
    for steps in parts.values():
        steps.over(seed=1000, passes=0)  # warm: the first calls load what they need
        steps.clear()
    for seed in range(seeds):
        for steps in parts.values():
            steps.over(seed, passes=passes if seed == 0 else 0)
        advance()
    policies = {policy: steps.figures() for policy, steps in parts.items()}
    default = Settings().policy
    result = {
        "step_ms": policies[default]["step_ms"],
        "ratio_to": policies[default]["ratio_to"],
        "certified_error_nm": max(figures["certified_error_nm"] for figures in policies.values()),
        "seeds": seeds,
        "default_policy": default,
        "policies": policies,
        "prediction": predictions(parts[default].model),
        "baselines": baselines(),
        "signals": signals(),
    }
    advance()
    return result


class _Steps:
    """Times of the steps of one policy [s]."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.model = Model.untrained(settings.gamma, settings.C, settings.epsilon)
        self.clear()

    def clear(self) -> None:
        self.step: list[float] = []
        self.svr: list[float] = []
        self.passes: list[float] = []
        self.step_beside_passes: list[float] = []
        self.size: list[int] = []
        self.certified: list[float] = []

    def over(self, seed: int, passes: int) -> None:
        """One repetition: T1 and T2 in batches."""
        experiment = leng.experiment(seed)
        samples = Samples.concatenate([experiment.T1, experiment.T2])
        samples = Samples(0.6 * np.arange(len(samples), dtype=np.float64), samples.yaw_rate, samples.damping)
        state, batch = start(self.settings), self.settings.batch
        for first in range(0, len(samples) - batch + 1, batch):
            part = samples.take(slice(first, first + batch))
            began = thread_time()
            state, iteration = step(self.settings, state, part)
            taken = thread_time() - began
            self.certified.append(iteration.model.certified_error)
            if not iteration.trained or len(iteration.old) == 0:
                continue
            self.step.append(taken)
            self._peers(iteration, taken, with_passes=passes > len(self.passes))
        self.model = state.model

    def _peers(self, iteration: Iteration, taken: float, with_passes: bool) -> None:
        trained = Samples.concatenate([iteration.old, iteration.new])
        x, y, settings = trained.yaw_rate, trained.damping, self.settings
        self.size.append(len(trained))
        began = thread_time()
        SVR(kernel="rbf", gamma=settings.gamma, C=settings.C, epsilon=settings.epsilon).fit(x[:, None], y)
        self.svr.append(thread_time() - began)
        if with_passes:
            began = thread_time()
            coordinate_descent(
                x, y, gamma=settings.gamma, C=settings.C, epsilon=settings.epsilon, passes=100_000, gap=PASSES_GAP
            )
            self.passes.append(thread_time() - began)
            self.step_beside_passes.append(taken)

    def figures(self) -> dict[str, Any]:
        median, p99 = 1e3 * np.median(self.step), 1e3 * np.percentile(self.step, 99)
        return {
            "step_ms": {"median": float(median), "p99": float(p99), "p99_over_median": float(p99 / median)},
            "samples_trained_on": {"median": float(np.median(self.size)), "most": max(self.size)},
            "steps": len(self.step),
            "ratio_to": {
                "sklearn_svr_fit": float(np.median(self.svr) / np.median(self.step)),
                "coordinate_descent": float(np.median(self.passes) / np.median(self.step_beside_passes)),
            },
            "sklearn_svr_fit_ms": float(1e3 * np.median(self.svr)),
            "coordinate_descent_ms": float(1e3 * np.median(self.passes)),
            "certified_error_nm": max(self.certified),
        }


def predictions(model: Model) -> dict[str, Any]:
    """The served model's prediction, with its uncertainty, beside scikit-learn's bare one with as many vectors [µs]."""
    x, y = model.support_rate, model.support_damping
    peer = SVR(kernel="rbf", gamma=model.gamma, C=model.C, epsilon=0.0).fit(x[:, None], y)
    result: dict[str, Any] = {"vectors": int(x.size), "vectors_of_sklearn": int(peer.support_.size)}
    low, high = model.trained_range or (0.0, 0.0)
    for size in SIZES:
        # Where both were trained: beyond it ours continues by physics and says so, the other falls back to its bias.
        rates = np.linspace(low, high, size + 2)[1:-1]
        ours, theirs = _in_turn(
            partial(model.predict, rates), partial(peer.predict, rates[:, None]), 20_000 // size + 30
        )
        result[f"{size}_rates"] = {"us": 1e6 * ours, "sklearn_us": 1e6 * theirs, "ratio": theirs / ours}
    return result


def _in_turn(ours: Callable[[], object], theirs: Callable[[], object], repeats: int) -> tuple[float, float]:
    """Median times of two calls [s], measured in turn."""
    times: list[tuple[float, float]] = []
    for _ in range(min(repeats, 2000)):
        first = thread_time()
        ours()
        second = thread_time()
        theirs()
        times.append((second - first, thread_time() - second))
    median = np.median(times, axis=0)
    return float(median[0]), float(median[1])


def baselines() -> dict[str, float]:
    """What learning all of T1 takes by each method [ms]; the learners do it in fourteen steps."""
    recording = leng.recording("T1", 0)
    streams = recording.streams()
    data = Data.of(leng.samples(recording), streams["yaw_rate"], streams["torque"])
    methods: dict[str, Baseline] = {
        "offline_svr": OfflineSVR(epsilon=2.0),
        "least_squares": LeastSquares(),
        "recursive_least_squares": RecursiveLeastSquares(),
        "adaptive_identifier": AdaptiveIdentifier(),
    }
    result = {}
    for name, method in methods.items():
        times = []
        for _ in range(5):
            began = thread_time()
            method.fit(data)
            times.append(thread_time() - began)
        result[f"{name}_ms"] = 1e3 * float(np.median(times))
    return result


def signals(duration: float = 4000.0) -> dict[str, float]:
    """What the synchroniser takes in, per stream and second of one core: two streams of 50 Hz, beside each other."""
    time = np.arange(0.0, duration, 0.02)
    rate, torque = 0.2 * np.sin(0.1 * time), 60.0 * np.sin(0.1 * time)
    batched = Synchroniser(SignalSettings())
    began = thread_time()
    for first in range(0, time.size, 500):
        part = slice(first, first + 500)
        batched.push("yaw_rate", time[part], rate[part])
        batched.push("torque", time[part], torque[part])
        batched.ready()
    in_batches = time.size / (thread_time() - began)
    single = Synchroniser(SignalSettings())
    size = min(time.size, 50_000)
    triples = list(zip(time[:size].tolist(), rate[:size].tolist(), torque[:size].tolist(), strict=True))
    began = thread_time()
    for stamp, one, other in triples:
        single.push_one("yaw_rate", stamp, one)
        single.push_one("torque", stamp, other)
        single.ready()
    return {"batched_per_second": in_batches, "single_per_second": size / (thread_time() - began)}
