"""The paper's policy beside the weighted one and the baselines that the paper cites.

Streams of damping samples of the simulated Leng, whose true curve is known at every moment, with one event each. Table
I and Fig. 7 are those of `incsvr table1`. Every error is the lower the better; the weighted policy learns with its own
kernel width, as it is recommended.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.baselines import Baseline, Data, LeastSquares, LeastSquaresSVR, NeuralNetwork, RecursiveLeastSquares
from benchmarks.study import SIGMAS_OF_95, Record, grouped, run, seeds, spread, table
from incsvr.learning.learner import Settings, start, step
from incsvr.numerics import Array, root_mean_square
from incsvr.signals.samples import Samples
from simulator import leng

SETTINGS = {"paper": Settings(policy="paper"), "weighted": Settings(policy="weighted", gamma=30.0)}
"""By policy; vectors that average many samples allow a narrower kernel."""
BASELINES: dict[str, Baseline] = {
    "least squares": LeastSquares(),
    "recursive least squares": RecursiveLeastSquares(),
    "neural network": NeuralNetwork(),
    "least-squares SVR": LeastSquaresSVR(),
}
"""Fitted at the end to the last FITTED samples, because most of them do not forget by themselves."""
FITTED = 500
BEFORE = 700
"""Samples before the event, as many as T1 has."""
RATES: Array = np.linspace(-0.24, 0.24, 97)
"""Where a curve is judged [rad/s]."""
Factor = Callable[[Array, Array], Array]


@dataclass(frozen=True, slots=True)
class Scenario:
    """A stream and its truth.

    Attributes:
        about: what happens.
        factor: (rates, sample numbers) → by what the damping is multiplied.
        offset: moment that is added from the event on [N m].
        low: largest yaw rate from the event on [rad/s].
        correlation: of two consecutive samples' noise.
        outliers: part of the samples that are 20 to 60 N m off.
        samples, event: how many samples, and from which on a curve is judged.
    """

    about: str
    factor: Factor = lambda r, k: np.ones(np.broadcast(r, k).shape)
    offset: float = 0.0
    low: float = 0.24
    correlation: float = 0.0
    outliers: float = 0.01
    samples: int = BEFORE + 550
    event: int = BEFORE

    def truth(self, rate: Array, k: Array) -> Array:
        """d [N m] at a yaw rate when sample k is taken."""
        return np.asarray(leng.damping(rate) * self.factor(rate, k) + self.offset * (k >= BEFORE))

    def draw(self, seed: int) -> Samples:
        """The stream: a sample each 0.6 s of a sinusoid, 4 N m of noise, 0.0015 rad/s of noise in the rate."""
        rng = np.random.default_rng([seed, *self.about.encode()])
        k = np.arange(self.samples, dtype=np.float64)
        rate = np.where(k < BEFORE, 0.24, self.low) * np.sin(2.0 * np.pi * k * 0.6 / 67.0 + rng.uniform(0.0, 6.3))
        noise = rng.normal(size=k.size)
        for i in range(1, k.size if self.correlation else 0):
            noise[i] = self.correlation * noise[i - 1] + np.sqrt(1.0 - self.correlation**2) * noise[i]
        wild = (rng.random(k.size) < self.outliers) * rng.choice([-1.0, 1.0], k.size) * rng.uniform(20.0, 60.0, k.size)
        damping = self.truth(rate, k) + 4.0 * noise + wild
        return Samples(0.6 * k, rate + 0.0015 * rng.normal(size=k.size), damping)


def _hull(r: Array, k: Array) -> Array:
    return np.asarray(1.0 + leng.HULL * (k >= BEFORE) * np.ones(np.shape(r)))


SCENARIOS = {
    "hull": Scenario("the hull adds 11.5 %", _hull),
    "outliers": Scenario("20 % outliers, and the hull", _hull, outliers=0.2),
    "correlated": Scenario("noise correlated at 0.8, and the hull", _hull, correlation=0.8),
    "bump": Scenario("+25 % within 0.03 rad/s of 0.12 rad/s alone",
                     lambda r, k: np.asarray(1.0 + 0.25 * (k >= BEFORE) * np.exp(-(((r - 0.12) / 0.03) ** 2)))),
    "one side": Scenario("+15 % at positive rates alone",
                         lambda r, k: np.asarray(1.0 + 0.15 * (k >= BEFORE) * (r > 0.0))),
    "offset": Scenario("6 N m are added", offset=6.0),
    "low speed": Scenario("1,000 samples within 0.06 rad/s, judged over all rates", low=0.06, samples=BEFORE + 1000),
    "drift": Scenario("+50 % over 2,000 samples", samples=2500, event=500,
                      factor=lambda r, k: np.asarray(1.0 + np.maximum(k - 500.0, 0.0) / 4000.0 * np.ones(np.shape(r)))),
    "nothing": Scenario("3,000 samples, nothing happens", samples=3000, event=200),
}  # fmt: skip


def cases(asked: argparse.Namespace) -> list[tuple[str, int]]:
    return [(name, seed) for name in SCENARIOS if asked.only in name for seed in seeds(asked)]


def examine(case: tuple[str, int]) -> Record:
    """RMS error of each policy's served curve since the event, in the last four batches, and shares in their bands."""
    scenario, samples = SCENARIOS[case[0]], SCENARIOS[case[0]].draw(case[1])
    found: Record = {"scenario": case[0], "seed": case[1]}
    with threadpool_limits(1):
        for policy, settings in SETTINGS.items():
            state, errors, curves, unseen = start(settings), [], [], []
            for first in range(0, len(samples) - settings.batch + 1, settings.batch):
                batch, model = samples.take(slice(first, first + settings.batch)), state.model
                if first >= scenario.event + settings.batch:  # the first batch behind the event shows what came
                    served = model.predict(batch.yaw_rate)
                    unseen.append(np.abs(served.damping - batch.damping) <= SIGMAS_OF_95 * served.sigma)
                state, _ = step(settings, state, batch)
                if first + settings.batch > scenario.event:
                    curve = state.model.predict(RATES)
                    off = curve.damping - scenario.truth(RATES, np.array([first + settings.batch - 1.0]))
                    errors.append(root_mean_square(off))
                    curves.append(np.abs(off) <= SIGMAS_OF_95 * curve.curve_sigma)
            found[policy] = {"since": float(np.mean(errors)), "end": float(np.mean(errors[-4:])),
                             "truth": float(np.mean(curves)), "samples": float(np.mean(unseen))}  # fmt: skip
        data = Data(samples.take(slice(-FITTED, None)), *(np.empty(0),) * 3)
        truth = scenario.truth(RATES, np.array([scenario.samples - 1.0]))
        found["baselines"] = {name: root_mean_square(method.fit(data)(RATES) - truth)
                              for name, method in BASELINES.items()}  # fmt: skip
    return found


def report(results: Sequence[Record]) -> Iterator[str]:
    rows, bands = [], []
    for name, own in grouped(results, "scenario").items():
        errors = {policy: np.array([[one[policy][key] for key in ("since", "end", "truth", "samples")] for one in own])
                  for policy in SETTINGS}  # fmt: skip
        better = int(np.count_nonzero(errors["weighted"][:, 0] < errors["paper"][:, 0]))
        rows.append([f"{name}: {SCENARIOS[name].about}",
                     *(spread(errors[policy][:, k]) for k in (0, 1) for policy in SETTINGS), f"{better} of {len(own)}",
                     *(spread([one["baselines"][each] for one in own]) for each in BASELINES)])  # fmt: skip
        bands.append([name, *(f"{100 * errors[policy][:, k].mean():.1f}" for k in (2, 3) for policy in SETTINGS)])
    yield "RMS error of the curve over ±0.24 rad/s [N m], mean ± standard deviation over the seeds."
    both = [f"{policy}, {when}" for when in ("since the event", "last four batches") for policy in SETTINGS]
    yield table(["scenario", *both, "weighted better since", *BASELINES], rows)
    yield "Shares within the band of 95 % since the event [%]: the true curve; samples of the next batch."
    yield table(["scenario", *(f"{of}, {policy}" for of in ("curve", "samples") for policy in SETTINGS)], bands)


def main(words: Sequence[str] | None = None) -> None:
    run("paper", __doc__, cases, examine, report, words, ("scikit-learn",), seeds=(20, "streams of each scenario"),
        first_seed=(790_000, "of them"), only=("", "part of the scenario's name"))  # fmt: skip


if __name__ == "__main__":
    main()
