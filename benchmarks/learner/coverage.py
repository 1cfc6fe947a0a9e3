"""How often bands of 95 % hold what they should: fresh samples within ±1.96 σ, the truth within the curve's own band.

`make coverage`. In five bands of yaw rate, for both policies, on the simulated Leng and on samples whose noise is
correlated at 0.9. Every figure is the mean over the seeds and over all iterations of a run from the fourth on: a band
must be right whenever it is served.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, pairwise

import numpy as np

from benchmarks.learner.policies import POLICIES, Policy, batches
from benchmarks.learner.policy_scenarios import SAMPLES_BEFORE, Scenario
from benchmarks.study import Record, begin, in_processes, options, publish
from benchmarks.tables import SIGMAS_OF_95, grouped, page, table
from incsvr.learning.criteria import Mask
from incsvr.learning.learner import Settings, start, step
from incsvr.learning.model import Model
from incsvr.numerics import Array
from incsvr.signals.samples import Samples
from simulator import leng

FIRST_SEED = 640_000
"""Seeds from here on are for the published table alone."""
BAND_EDGES = (0.0, 0.05, 0.10, 0.15, 0.20, 0.25)
"""Edges of the five bands of |r| [rad/s]."""
RATES_PER_BAND = 10
"""Rates at which the curve is judged in each band, to each side."""
FIRST_JUDGED_ITERATION = 4
"""From this iteration of a run on the bands are judged."""
NOISE_ITERATIONS = (1, 2, 3, 4, 14)
"""Iterations of the first run after which the noise level is told."""
CORRELATED = Scenario("noise correlated at 0.9, nothing happens", samples=SAMPLES_BEFORE, correlation=0.9, outliers=0.0)


@dataclass(frozen=True, slots=True)
class Run:
    """A stretch of samples to learn from.

    Attributes:
        name: what it is.
        training: to learn from.
        unseen: samples of the same vehicle with noise of their own.
        truth: d(r) [N m] of this vehicle at (n,) rates [rad/s].
    """

    name: str
    training: Samples
    unseen: Samples
    truth: Callable[[Array], Array]


def voyages(seed: int) -> Iterator[tuple[Run, ...]]:
    """What a learner goes through from its start on, run after run."""
    data = leng.experiment(seed)
    yield (
        Run("Leng, T1", data.T1, data.V1, leng.damping),
        Run("Leng, T2: the hull on", data.T2, data.V2, lambda rate: leng.damping(rate, True)),
    )
    unseen = CORRELATED.draw(seed + 1_000_000)
    yield (Run("noise correlated at 0.9", CORRELATED.draw(seed), unseen, leng.damping),)


def judged(model: Model, run: Run) -> tuple[Array, Array]:
    """Shares (5,) of the samples within ±1.96 σ, and of the truth within the curve's band; NaN where none is asked."""
    edges = np.array(BAND_EDGES)
    size = (edges[:-1, None] + np.diff(edges)[:, None] * (np.arange(RATES_PER_BAND) + 0.5) / RATES_PER_BAND).ravel()
    rates = np.concatenate((-size, size))
    curve, sampled = model.predict(rates), model.predict(run.unseen.yaw_rate)
    true_held = np.abs(run.truth(rates) - curve.damping) <= SIGMAS_OF_95 * curve.doubt
    sample_held = np.abs(run.unseen.damping - sampled.damping) <= SIGMAS_OF_95 * sampled.sigma
    return (
        _by_band(run.unseen.yaw_rate[~sampled.extrapolated], sample_held[~sampled.extrapolated]),
        _by_band(rates[~curve.extrapolated], true_held[~curve.extrapolated]),
    )


def _by_band(rate: Array, held: Mask) -> Array:
    place = np.digitize(np.abs(rate), BAND_EDGES) - 1
    return np.array(
        [held[place == band].mean() if (place == band).any() else np.nan for band in range(len(BAND_EDGES) - 1)]
    )


def voyage(runs: Sequence[Run], policy: Policy) -> list[Record]:
    """A record for each run: both coverages (5,) as means over its iterations, and the noise level after each."""
    settings = Settings(policy=policy)
    state, records = start(settings), []
    for run in runs:
        shares, sigmas = [], []
        for number, batch in enumerate(batches(run.training, settings.batch), 1):
            state, iteration = step(settings, state, batch)
            sigmas.append(iteration.model.sigma)
            if number >= FIRST_JUDGED_ITERATION:
                shares.append(judged(iteration.model, run))
        samples, curve = (np.nanmean(part, axis=0).tolist() for part in zip(*shares, strict=True))
        records.append({"run": run.name, "policy": policy, "samples": samples, "curve": curve, "sigma": sigmas})
    return records


def examine(seed: int) -> list[Record]:
    """The records of a seed."""
    return [record | {"seed": seed} for runs in voyages(seed) for policy in POLICIES for record in voyage(runs, policy)]


def report(document: Record) -> str:
    """Markdown."""
    runs = {name: grouped(own, "policy") for name, own in grouped(document["records"], "run").items()}
    bands = [f"{low:g}–{high:g} rad/s" for low, high in pairwise(BAND_EDGES)]
    first = next(iter(runs))
    noise = [
        [policy, *(f"{part.mean():.2f} ± {part.std(ddof=min(1, part.size - 1)):.2f}" for part in sigma.T)]
        for policy, own in runs[first].items()
        for sigma in [np.array([record["sigma"] for record in own])[:, np.array(NOISE_ITERATIONS) - 1]]
    ]
    return page(
        "# How often the bands of 95 % hold what they should",
        f"Made by `{document['command']}` on {document['date']}, seeds {document['seeds']}. Shares in %, mean ± "
        f"standard error over the seeds, over all iterations of a run from number {FIRST_JUDGED_ITERATION} on.",
        "## Fresh samples within ±1.96 σ",
        table(["run", "policy", *bands, "all"], _shares(runs, "samples")),
        "## The truth within the curve's own band",
        table(["run", "policy", *bands, "all"], _shares(runs, "curve")),
        f"## The noise level that is served, {first} [N m]",
        "Mean ± standard deviation over the seeds.",
        table(["policy", *(f"after iteration {number}" for number in NOISE_ITERATIONS)], noise),
    )


def _shares(runs: Record, key: str) -> list[list[str]]:
    rows = []
    for name, policies in runs.items():
        for policy, own in policies.items():
            values = 100.0 * np.array([record[key] for record in own], dtype=np.float64)
            error = np.nanstd(values, axis=0, ddof=1) / np.sqrt(len(own)) if len(own) > 1 else 0.0 * values[0]
            cells = [f"{m:.1f} ± {e:.1f}" for m, e in zip(np.nanmean(values, axis=0), error, strict=True)]
            rows.append([name, policy, *cells, f"{np.nanmean(values):.1f}"])
    return rows


def main(words: Sequence[str] | None = None) -> None:
    parser = options(
        "benchmarks.learner.coverage",
        __doc__,
        seeds=(20, "voyages of each kind"),
        first_seed=(FIRST_SEED, "of them"),
        processes=(1, "seeds at once"),
    )
    args, measured = begin(parser, words)
    seeds = range(args.first_seed, args.first_seed + args.seeds)
    records = chain.from_iterable(in_processes(examine, seeds, "seeds", args.processes))
    document = measured | {"seeds": f"{seeds[0]}–{seeds[-1]}", "records": list(records)}
    publish(args.out, "coverage", document, report(document))


if __name__ == "__main__":
    main()
