"""Damping over several velocities beside the decoupled learner, least squares with cross terms and a Gaussian process.

Simulated vehicles whose damping couples surge, sway and yaw (simulator/planar.py), judged by the true d(ν) of yaw at
the velocities of a second run; and every axis of the measured vehicles on which surge and sway were recorded, judged by
the samples of recordings that were not fitted. Every method gets the same samples of Eq. 5. A method of N vectors may
keep N: the learners choose theirs, least squares and the Gaussian process take every k-th sample. Least squares of all
samples stands beside them as what no small memory can have. `make several`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations
from typing import Any, cast

import numpy as np

from benchmarks.learner import solver
from benchmarks.learner.policies import POLICIES
from benchmarks.study import CORES, MEASURED, Record, begin, in_processes, options, publish
from benchmarks.tables import SIGMAS_OF_95, page, table
from benchmarks.vehicles.gaussian_process import Predictor, gaussian_process
from benchmarks.vehicles.splits import SPLITS, Split
from incsvr.checks import Vehicle
from incsvr.learning import checked_learner
from incsvr.learning.learner import Settings
from incsvr.learning.model import Model
from incsvr.learning.velocities import points
from incsvr.numerics import Array, root_mean_square
from incsvr.plant.axes import AXES, stream_of
from incsvr.signals.samples import Samples
from service.recordings.recording import sequence
from service.recordings.recording_csv import read
from service.recordings.samples_from_recording import learner_for, samples_of, signals_for
from simulator import leng, planar

VECTORS = (60, 200)
PLANAR = ("surge", "sway")
DOUBLED = "declared four times too small"
"""What the splits say of the one axis that is asked twice."""


@dataclass(frozen=True, slots=True)
class Case:
    """What the methods of one row are given.

    Attributes:
        name: of the vehicle and the axis.
        fitted, unseen: samples with the further velocities as channels.
        others: their names.
        truth: (m,) what the unseen ones are judged by [N m].
        settings: of a learner over the own velocity.
        vehicle: what the checks are told.
    """

    name: str
    fitted: Samples
    unseen: Samples
    others: tuple[str, ...]
    truth: Array
    settings: Settings
    vehicle: Vehicle

    @staticmethod
    def simulated(seed: int) -> Case:
        body = planar.Planar.drawn(seed)
        signals = replace(leng.SIGNALS, inertia=body.inertia)
        there, here = (samples_of(planar.recording(seed, run=run), signals, None, None, PLANAR)[0] for run in (1, 2))
        u, v = (here.channels[name] for name in PLANAR)
        truth = planar.truth(body, u, v, here.yaw_rate, with_munk=True)
        settings = Settings()
        vehicle = Vehicle(body.inertia, settings.rate_range, signals.smoothing)
        return Case("simulated, yaw", there, here, PLANAR, truth, settings, vehicle)

    @staticmethod
    def measured(split: Split) -> Case:
        axis = AXES[split.axis]
        others = tuple(stream_of(axis, name) for name in (*PLANAR, "yaw_rate") if name != axis.rate)
        runs = [
            [read(MEASURED / split.vehicle / f"{name}.csv", axis=axis, rate_limit=axis.fastest) for name in names]
            for names in (split.fitted, split.unseen)
        ]
        signals = signals_for(runs[0], split.inertia, axis.fastest)
        there, here = (samples_of(sequence(each), signals, None, None, others)[0] for each in runs)
        settings = replace(learner_for(there), own=axis.rate)
        vehicle = Vehicle(signals.inertia, settings.rate_range, signals.smoothing)
        return Case(f"{split.vehicle}, {split.axis}", there, here, others, here.damping, settings, vehicle)


def examine(case: int | Split) -> Record:
    """The errors of all methods on one case, and what the learner says of itself."""
    one = Case.simulated(case) if isinstance(case, int) else Case.measured(case)
    there, here = (points(each, one.others) for each in (one.fitted, one.unseen))
    record: Record = {
        "case": one.name,
        "seed": case if isinstance(case, int) else None,
        "split": None if isinstance(case, int) else case.name,
        "samples": [len(one.fitted), len(one.unseen)],
        "rms": _rms(one.truth),
        "errors": {"least squares of all": _rms(least_squares(there, one.fitted.damping)(here) - one.truth)},
        "learner": {},
    }
    errors = record["errors"]
    for count in VECTORS:
        some = np.unique(np.linspace(0, len(one.fitted) - 1, count).round().astype(int))
        for name, method in (("least squares", least_squares), ("gaussian process", gaussian_process)):
            errors[f"{name} {count}"] = _rms(method(there[some], one.fitted.damping[some])(here) - one.truth)
        for policy in POLICIES:
            for over, others in (("decoupled", ()), ("several", one.others)):
                model, aside = learned(one, policy, count, others)
                key = f"{over} {policy} {count}"
                if model is None:  # the checks put all aside, or nothing was evidence
                    errors[key] = None
                    continue
                said = model.at(one.unseen)
                left = said.damping - one.truth
                errors[key] = _rms(left)
                out = said.extrapolated
                record["learner"][key] = {
                    "extrapolated": float(out.mean()),
                    "inside": _rms(left[~out]),
                    "outside": _rms(left[out]),
                    "held": float(np.mean(np.abs(said.damping - one.unseen.damping) < SIGMAS_OF_95 * said.sigma)),
                    "put_aside": aside,
                    "certified_error": model.certified_error,
                }
    return record


def learned(case: Case, policy: str, capacity: int, others: tuple[str, ...]) -> tuple[Model | None, int]:
    """The last model of the online loop with its checks, and how many batches these put aside."""
    settings = replace(case.settings, policy=cast(Any, policy), capacity=capacity, others=others)
    model, aside = None, 0
    for verdict, iteration in checked_learner.follow(settings, case.vehicle, case.fitted, rest=True):
        aside += not verdict.learn
        if iteration is not None and iteration.model.is_trained:
            model = iteration.model
    return model, aside


def least_squares(velocity: Array, damping: Array) -> Predictor:
    """Damping to second order with every cross term: νᵢ, νᵢ|νᵢ|, νᵢ|νⱼ| and νᵢνⱼ of all, without symmetry."""
    scale = np.abs(velocity).max(axis=0)
    best = np.linalg.lstsq(_terms(velocity / scale), damping, rcond=None)[0]
    return lambda asked: np.asarray(_terms(asked / scale) @ best)


def _terms(u: Array) -> Array:
    d = range(u.shape[1])
    columns = [u[:, i] for i in d] + [u[:, i] * np.abs(u[:, i]) for i in d]
    columns += [u[:, i] * np.abs(u[:, j]) for i, j in permutations(d, 2)]
    columns += [u[:, i] * u[:, j] for i, j in combinations(d, 2)]
    return np.stack(columns, axis=1)


def _rms(values: Array) -> float | None:
    return root_mean_square(values) if values.size else None


def methods() -> list[str]:
    """The methods in the order of the table: by what they are, then by how many vectors they keep."""
    kinds = ("several weighted", "several paper", "decoupled weighted", "decoupled paper", "least squares",
             "gaussian process")  # fmt: skip
    return [f"{kind} {count}" for kind in kinds for count in VECTORS] + ["least squares of all"]


def simulated_rows(records: Sequence[Record]) -> list[list[str]]:
    """One row a method: median, quartiles and worst of its error, and of the learner's own account."""
    rows = []
    for method in methods():
        errors = np.array([record["errors"][method] or np.nan for record in records])
        low, middle, high = np.nanquantile(errors, (0.25, 0.5, 0.75))
        told = [record["learner"][method] for record in records if method in record["learner"]]

        def mean(name: str, told: Sequence[Record] = told) -> str:
            known = [each[name] for each in told if each[name] is not None]
            return f"{np.mean(known):.2f}" if known else "–"

        rows.append([
            method, f"{middle:.2f}", f"{low:.2f}–{high:.2f}", f"{np.nanmax(errors):.2f}",
            mean("inside"), mean("outside"), mean("extrapolated"), mean("held"), mean("put_aside"),
        ])  # fmt: skip
    return rows


def measured_rows(records: Sequence[Record]) -> list[list[str]]:
    """One row a split."""

    def cell(record: Record, method: str) -> str:
        error = record["errors"][method]
        if error is None:
            return "–"
        out = record["learner"].get(method, {}).get("extrapolated", 0.0)
        return f"{error:.3g}" + (f" ({100 * out:.0f} %)" if out >= 0.005 else "")

    shown = methods()
    return [
        [record["split"], f"{record['rms']:.3g}", *(cell(record, method) for method in shown)] for record in records
    ]


def report(document: Record) -> str:
    """Markdown."""
    simulated = [record for record in document["records"] if record["seed"] is not None]
    measured = [record for record in document["records"] if record["seed"] is None]
    speed = document["solver"]
    head = ["method and vectors", "RMS error [N m]", "quartiles", "worst", "inside", "outside", "extrapolated", "held",
            "batches put aside"]  # fmt: skip
    return page(
        "# Damping of several velocities",
        f"Made by `{document['command']}` on {document['date']}, {document['processor']}, load "
        f"{document['load_before']:.1f}.",
        "## Simulated vehicles",
        f"{len(simulated)} vehicles, seeds from {document['first_seed']}; d of yaw over yaw "
        f"rate, surge and sway, RMS {np.mean([record['rms'] for record in simulated]):.1f} N m; noise of a sample "
        "about 3.3 N m. Median over the vehicles of the RMS error against the true d(ν) of a second run, quartiles and "
        "worst; means of the error where the model says that it was driven and where it extrapolates, of the share of "
        "the latter, of the samples that the band of 95 % holds, and of the batches of 20 that the checks put aside.",
        table(head, simulated_rows(simulated)),
        "## Measured vehicles",
        "RMS residual of samples of Eq. 5 from recordings that were not fitted [N] or "
        "[N m], with the share of them that the model calls extrapolated; no mass matrix is declared, so that Coriolis "
        "counts as damping.",
        table(["fitted → unseen", "RMS of d", *methods()], measured_rows(measured)),
        "## The exact solver in six dimensions",
        f"{speed['n']} samples: {speed['solve_ms']['median']:.2f} ms in "
        f"the median, `SVR.fit` {speed['sklearn_svr_fit_ms']:.2f} ms in turn in the same process: "
        f"{speed['ratio_to_sklearn_svr_fit']:.2f} times as fast.",
    )


def main(words: Sequence[str] | None = None) -> None:
    parser = options(
        "benchmarks.learner.several",
        __doc__,
        seeds=(20, "simulated vehicles"),
        first_seed=(920_000, "of them"),
        processes=(CORES, "vehicles at once"),
    )
    args, measured = begin(parser, words, "scikit-learn")
    splits = [split for split in SPLITS if MEASURED.is_dir() and split.vehicle != "bluerov" and split.about != DOUBLED]
    cases: list[int | Split] = [*range(args.first_seed, args.first_seed + args.seeds), *splits]
    document = measured | {
        "first_seed": args.first_seed,
        "solver": solver.six_dimensions(),
        "records": in_processes(examine, cases, "vehicles", args.processes),
    }
    publish(args.out, "several", document, report(document))


if __name__ == "__main__":
    main()
