"""How long the learner's step, its exact solver, its prediction and its signals take, beside other libraries in turn.

Every step is timed from inclusion to certificate. scikit-learn's SVR then trains on exactly the samples that this step
trained on, and after some steps Eq. 8's passes too, so that all see the same problem at the same moment. scikit-learn's
`SVR.fit` solves another problem, with a bias; Eq. 8's passes and clarabel solve ours. Times are the thread's on its
processor: what else the machine does is not in them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from time import thread_time
from typing import Any

import clarabel
import numpy as np
from scipy import sparse
from sklearn.svm import SVR

from benchmarks.baselines import AdaptiveIdentifier, Baseline, Data, LeastSquares, OfflineSVR, RecursiveLeastSquares
from benchmarks.repetition import LEARNERS
from incsvr.learning import dual
from incsvr.learning.kernel import rbf
from incsvr.learning.learner import Iteration, Settings, start, step
from incsvr.learning.model import Model
from incsvr.numerics import Array
from incsvr.signals import SignalSettings, Synchroniser
from incsvr.signals.samples import Samples
from simulator import leng

GAMMA, C, EPSILON = 10.0, 1000.0, 0.1  # as the paper found them (Section IV-B)
PASSES_GAP = 1e-2
"""Relative duality gap to which Eq. 8's passes run; it certifies some 80 N m, and takes thousands of passes."""
SIZES = (1, 100, 10_000)

Set = tuple[Array, Array]
"""x (n,) or (n, d) and y (n,)."""


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
        self.step, self.svr, self.passes = list[float](), list[float](), list[float]()
        self.step_beside_passes, self.certified, self.size = list[float](), list[float](), list[int]()

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
            if iteration.trained and len(iteration.old):
                self.step.append(taken)
                self._peers(iteration, taken, with_passes=passes > len(self.passes))
        self.model = state.model

    def _peers(self, iteration: Iteration, taken: float, with_passes: bool) -> None:
        trained, settings = Samples.concatenate([iteration.old, iteration.new]), self.settings
        given, hyper = (trained.yaw_rate, trained.damping), (settings.gamma, settings.C, settings.epsilon)
        self.size.append(len(trained))
        self.svr.append(_seconds(partial(_svr, given, *hyper)))
        if with_passes:
            self.passes.append(_seconds(partial(_passes, given, *hyper)))
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
        one, other = partial(model.predict, rates), partial(peer.predict, rates[:, None])
        times = [(_seconds(one), _seconds(other)) for _ in range(min(20_000 // size + 30, 2000))]
        ours, theirs = np.median(times, axis=0).tolist()
        result[f"{size}_rates"] = {"us": 1e6 * ours, "sklearn_us": 1e6 * theirs, "ratio": theirs / ours}
    return result


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
    return {
        f"{name}_ms": 1e3 * float(np.median([_seconds(partial(method.fit, data)) for _ in range(5)]))
        for name, method in methods.items()
    }


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


def solver(sets: int = 200, few: int = 5, offline: int = 2000) -> dict[str, Any]:
    """Figures of the exact solver alone.

    Args:
        sets: how many sets of 110 samples, one for each seed.
        few: on how many of them clarabel and Eq. 8's passes run: they take up to a second each.
        offline: samples of an offline set.
    """
    online = [yaw_samples(seed) for seed in range(sets)]
    solutions = [dual.solve(x, y, gamma=GAMMA, C=C, epsilon=EPSILON) for x, y in online]
    walked = [_seconds(partial(_passes, samples)) for samples in online[:few]]
    figures = _beside_svr(online)
    wide = [_in_six_dimensions(seed) for seed in range(4 * few)]
    return {
        "sets": sets,
        **figures,
        "iterations": {
            "median": float(np.median([solution.iterations for solution in solutions])),
            "most": max(solution.iterations for solution in solutions),
        },
        "certified_error_nm": max(solution.certified_error for solution in solutions),
        "apart_from_clarabel_nm": max(
            float(np.abs(rbf(x, x, GAMMA) @ solution.weight - by_clarabel(x, y, GAMMA, C, EPSILON)).max())
            for (x, y), solution in zip(online[:few], solutions, strict=False)
        ),
        "ratio_to_coordinate_descent": 1e3 * float(np.median(walked)) / figures["solve_ms"]["median"],
        "offline": _beside_svr(
            [yaw_samples(seed, old=offline // 2, new=offline - offline // 2) for seed in range(few)]
        ),
        "six_dimensions": _beside_svr(wide),
    }


def by_clarabel(x: Array, y: Array, gamma: float, C: float, epsilon: float) -> Array:
    """f (n,) at the samples by an interior point that shares nothing with ours.

    The primal min ½‖w‖² + C Σ (ξᵢ + ξ'ᵢ) with y − Lw ≤ ε + ξ and Lw − y ≤ ε + ξ', L from the kernel's eigenvectors.
    """
    n = y.size
    values, vectors = np.linalg.eigh(rbf(x, x, gamma))
    L = vectors[:, values > 1e-15] * np.sqrt(values[values > 1e-15])
    rank = L.shape[1]
    one, none, low, aside = sparse.eye(n), sparse.csc_matrix((n, n)), sparse.csc_matrix(L), sparse.csc_matrix((n, rank))
    A = sparse.block_array([[-low, -one, none], [low, none, -one], [aside, -one, none], [aside, none, -one]])
    P = sparse.diags(np.r_[np.ones(rank), np.zeros(2 * n)])
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs, settings.tol_gap_rel, settings.tol_feas = 1e-13, 1e-15, 1e-13
    solution = clarabel.DefaultSolver(
        sparse.csc_matrix(P),
        np.r_[np.zeros(rank), np.full(2 * n, C)],
        sparse.csc_matrix(A),
        np.r_[epsilon - y, epsilon + y, np.zeros(2 * n)],
        [clarabel.NonnegativeConeT(4 * n)],
        settings,
    ).solve()
    return np.asarray(L @ np.array(solution.x[:rank]))


def yaw_samples(seed: int, old: int = 60, new: int = 50, noise: float = 4.0) -> Set:
    """Samples of the kind that the learner trains on: old vectors over the whole range, a stretch of a sinusoid."""
    rng = np.random.default_rng(seed)
    phase = rng.uniform(0.0, 2.0 * np.pi)
    x_old = 0.25 * np.sin(rng.uniform(0.0, 2.0 * np.pi, old))
    x_new = 0.25 * np.sin(phase + np.linspace(0.0, 1.2, new)) + rng.normal(size=new) * 0.002
    x = np.concatenate([x_old, x_new])
    return x, 1300.0 * x * np.abs(x) + 40.0 * x + noise * rng.normal(size=x.size)


def _in_six_dimensions(seed: int) -> Set:
    """Where the kernel has full rank: six velocities of half a unit, the first with a quadratic drag."""
    rng = np.random.default_rng(seed)
    x = 0.5 * rng.normal(size=(110, 6))
    return x, 60.0 * x[:, 0] * np.abs(x[:, 0]) + 4.0 * rng.normal(size=110)


def _beside_svr(sets: Sequence[Set]) -> dict[str, Any]:
    """Solving each set and `SVR.fit` on it, in turn."""
    _ours(sets[0])  # warm: the first calls load what they need
    _svr(sets[0])
    times = np.array([(_seconds(partial(_ours, samples)), _seconds(partial(_svr, samples))) for samples in sets])
    ours, theirs = np.median(times, axis=0)
    return {
        "n": sets[0][1].size,
        "solve_ms": {"median": 1e3 * float(ours), "p99": 1e3 * float(np.percentile(times[:, 0], 99))},
        "sklearn_svr_fit_ms": 1e3 * float(theirs),
        "ratio_to_sklearn_svr_fit": float(theirs / ours),
    }


def _seconds(call: Callable[[], object]) -> float:
    began = thread_time()
    call()
    return thread_time() - began


def _ours(samples: Set) -> object:
    return dual.solve(*samples, gamma=GAMMA, C=C, epsilon=EPSILON)


def _passes(samples: Set, gamma: float = GAMMA, bound: float = C, epsilon: float = EPSILON) -> object:
    return dual.coordinate_descent(*samples, gamma=gamma, C=bound, epsilon=epsilon, passes=100_000, gap=PASSES_GAP)


def _svr(samples: Set, gamma: float = GAMMA, bound: float = C, epsilon: float = EPSILON) -> object:
    x, y = samples
    return SVR(gamma=gamma, C=bound, epsilon=epsilon).fit(x.reshape(y.size, -1), y)
