"""Ordinary missions with nothing hidden: the curve that is served, and what is falsely named.

Each mission's log goes through `incsvr fit` with both policies and through `incsvr trace`. Served is compared with the
true damping at rates that the vehicle really turned at, no nearer to rest than half of the largest. Near is within a
tenth of the truth, or within 1.5 deviations of the water's moment.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.study import SIGMAS_OF_95, Record, grouped, run, seeds, share, table
from benchmarks.trace import answer
from incsvr.errors import BadInput
from incsvr.learning.model import Model
from incsvr.numerics import Array
from service.fitting.fit import Fit
from service.fitting.terms import Terms
from service.fitting.training import AS_GIVEN
from service.recordings.reading import RATE_LIMIT
from service.recordings.samples_from_recording import signals_for
from simulator.mission import Mission
from simulator.plans import PLANS
from simulator.vehicles import TURNING, YAW
from simulator.world import Outcome, play

NEAR_SHARE, NEAR_WATER_RATIO, OUTER_RATE_SHARE = 0.1, 1.5, 0.5
IDLE = ("carried", "station")
"""Missions that hardly drive the vehicle: nobody can learn much from them."""
DWELL_S, RATE_BINS = 2.0, 20
"""A rate is driven where the vehicle spends so long in one of so many bins."""


@dataclass(frozen=True, slots=True)
class Case:
    """A mission: its kind, its vehicle, its seed and its length [s]."""

    kind: str
    vehicle: str
    seed: int
    duration: float


def examine(case: Case) -> Record:
    """A mission's log, learned and traced."""
    outcome = play(Mission(TURNING[case.vehicle], case.kind, case.seed, duration=case.duration))
    found: Record = {"kind": case.kind, "vehicle": case.vehicle, "seed": case.seed}
    for policy in ("paper", "weighted"):
        signals = signals_for([outcome.recording], outcome.inertia, RATE_LIMIT)
        try:
            fit = Fit.of([outcome.recording], [], signals, Terms(chosen={"policy": policy}, by_person=AS_GIVEN))
        except BadInput as refusal:
            found[policy] = {"refused": str(refusal)}
            continue
        found[policy] = judged(outcome, fit.model)
    return found | answer(outcome.recording, outcome.inertia)


def driven_rates(outcome: Outcome) -> Array:
    """(m,) rates at which the vehicle turned for a while [rad/s]."""
    rate = outcome.true("yaw_rate")
    times, edges = np.histogram(rate, RATE_BINS)
    step = float(outcome.time[1] - outcome.time[0])
    return np.asarray(0.5 * (edges[1:] + edges[:-1])[step * times >= DWELL_S])


def judged(outcome: Outcome, model: Model) -> Record:
    """What a model serves against the truth."""
    if not model.is_trained or model.trained_range is None:
        return {"refused": "nothing is trained"}
    rates = driven_rates(outcome)
    outer = rates[np.abs(rates) >= OUTER_RATE_SHARE * np.abs(rates).max()] if rates.size else rates
    prediction = model.predict(rates)
    served, true = prediction.damping, outcome.damping(rates)
    allowed = np.maximum(NEAR_SHARE * np.abs(true), NEAR_WATER_RATIO * outcome.water_rms[YAW])
    ratios = model.predict(outer).damping / outcome.damping(outer)
    band = SIGMAS_OF_95 * prediction.doubt
    return {
        "near": float(np.mean(np.abs(served - true) <= allowed)),
        "covered": float(np.mean(np.abs(served - true) <= band)),
        "drives": float(np.mean(served * np.sign(rates) < -band)),
        "ratios": ratios.tolist(),
    }


def report(records: Sequence[Record]) -> Iterable[str]:
    """A row for each kind of mission, then all that drive."""
    rows = [[kind, len(own), *_row(own)] for kind, own in grouped(records, "kind").items()]
    driving = [each for each in records if each["kind"] not in IDLE]
    rows.append(["**all that drive**", len(driving), *_row(driving)])
    head = ["mission", "runs"]
    for policy in ("paper", "weighted"):
        head += [f"{policy}: served ÷ truth, 5 to 95 %", "near", "in the band", "drives"]
    yield table([*head, "refused", "falsely named", "named"], rows)


def _row(own: Sequence[Record]) -> list[object]:
    cells: list[object] = []
    for policy in ("paper", "weighted"):
        fits = [each[policy] for each in own if "refused" not in each[policy]]
        ratios = [ratio for fit in fits for ratio in fit["ratios"]]
        low, middle, high = np.percentile(ratios, (5, 50, 95)) if ratios else (np.nan, np.nan, np.nan)
        cells.append(f"{low:.2f}, {middle:.2f}, {high:.2f}")
        cells += [
            f"{100 * np.mean([fit[key] for fit in fits]):.0f} %" if fits else "–"
            for key in ("near", "covered", "drives")
        ]
    refused = sum("refused" in each["paper"] for each in own)
    named = ", ".join(sorted({name for each in own for name in each["named"]})) or "–"
    return [*cells, refused, share(sum(bool(each["named"]) for each in own), len(own)), named]


def cases(asked: argparse.Namespace) -> list[Case]:
    """Every kind of mission with every vehicle, once a seed."""
    kinds = [kind for kind in PLANS if kind in asked.kinds.split(",") or asked.kinds == "all"]
    return [
        Case(kind, vehicle, seed, 60.0 * asked.minutes)
        for kind in kinds for vehicle in asked.vehicles.split(",") for seed in seeds(asked)
    ]  # fmt: skip


if __name__ == "__main__":
    run(
        "missions", __doc__, cases, examine, report, first_seed=(2_500_000, "of the missions"),
        seeds=(4, "missions of each kind and vehicle"), minutes=(30.0, "length of a mission"),
        kinds=("all", "of missions, with commas"), vehicles=("auv,rov,leng", "of them, with commas"),
    )  # fmt: skip
