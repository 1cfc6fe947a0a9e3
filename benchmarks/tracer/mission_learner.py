"""What the learner serves after an ordinary mission, against the vehicle's true damping."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.learner.policies import POLICIES
from benchmarks.study import Record
from benchmarks.tables import SIGMAS_OF_95, counted, grouped, table
from benchmarks.tracer.mission_cases import IDLE_KINDS, circumstance
from incsvr.errors import BadInput
from incsvr.learning.model import Model
from service.commands.fit_alternatives import AS_GIVEN
from service.commands.fit_result import Fit
from service.recordings.recording_csv import RATE_LIMIT
from service.recordings.samples_from_recording import signals_for
from simulator.missions import Outcome

NEAR_SHARE, NEAR_WATER_RATIO = 0.1, 1.5
"""A served moment is near the truth if it is off by no more than this share of it, or by so many water's deviations."""
OUTER_RATE_SHARE = 0.5
"""Ratios to the truth are taken beyond this share of the largest driven rate: at rest the truth is zero."""
BAND_RATES = 101
"""Over so many rates of the trained range the band is judged."""


def examine(outcome: Outcome) -> list[Record]:
    """A record for each policy: the mission's log through `incsvr fit`, judged by the truth."""
    mission = outcome.mission
    common = {
        "kind": mission.kind,
        "vehicle": mission.vehicle,
        "seed": mission.seed,
        "circumstance": circumstance(mission),
        "water_rms": outcome.water_rms,
    }
    return [common | {"policy": policy} | _fit(outcome, policy) for policy in POLICIES]


def _fit(outcome: Outcome, policy: str) -> Record:
    signals = signals_for([outcome.recording], outcome.inertia, RATE_LIMIT)
    try:
        fit = Fit.of([outcome.recording], [], signals, None, {"policy": policy}, by_person=AS_GIVEN)
    except BadInput as refusal:
        return {"refused": str(refusal)}
    except Exception as error:  # a crash is a result too, and the other missions go on
        return {"failed": f"{type(error).__name__}: {error}"}
    model = fit.iterations[-1].model
    return {"remarks": list(fit.remarks), "iterations": len(fit.iterations)} | judged(outcome, model)


def judged(outcome: Outcome, model: Model) -> Record:
    """What a model serves against the truth: over the rates that commands drove, and over all that was trained."""
    if not model.is_trained or model.trained_range is None:
        return {"trained_range": None}
    low, high = model.trained_range
    rates = outcome.driven_rates
    record: Record = {"trained_range": [low, high], "driven_rates": rates.tolist()}
    if rates.size:
        true, served = outcome.damping(rates), model.predict(rates).damping
        allowed = np.maximum(NEAR_SHARE * np.abs(true), NEAR_WATER_RATIO * outcome.water_rms)
        outer = np.abs(rates) >= OUTER_RATE_SHARE * np.abs(rates).max()
        record["near"] = float(np.mean(np.abs(served - true) <= allowed))
        record["ratios"] = (served[outer] / true[outer]).tolist()
    everywhere = np.linspace(low, high, BAND_RATES)
    prediction, true = model.predict(everywhere), outcome.damping(everywhere)
    answered = ~prediction.extrapolated
    if answered.any():
        served, band = prediction.damping[answered], SIGMAS_OF_95 * prediction.doubt[answered]
        record["covered"] = float(np.mean(np.abs(served - true[answered]) <= band))
        record["drives"] = float(np.mean(served * np.sign(everywhere[answered]) < -band))
        record["band"] = float(np.median(band))
    return record


def report(records: Sequence[Record]) -> str:
    """Markdown: a row for each kind and vehicle, both policies side by side, then both over everything."""
    rows = [
        [kind, vehicle, len(cell) // len(POLICIES), *_both(cell)]
        for kind, own in grouped(records, "kind").items()
        for vehicle, cell in grouped(own, "vehicle").items()
    ]
    driven = [record for record in records if record["kind"] not in IDLE_KINDS]
    idle = [record for record in records if record["kind"] in IDLE_KINDS]
    for name, chosen in (("all that drive", driven), ("all that hardly drive", idle)):
        if chosen:
            rows.append([f"**{name}**", "", len(chosen) // len(POLICIES), *_both(chosen)])
    head = ["mission", "vehicle", "runs"]
    for policy in POLICIES:
        head += [f"{policy}: served ÷ truth", "near", "covered", "drives", "remarks, refusals"]
    return table(head, rows)


def _both(records: Sequence[Record]) -> list[str]:
    cells = []
    for policy in POLICIES:
        chosen = [record for record in records if record["policy"] == policy]
        ratios = [ratio for record in chosen for ratio in record.get("ratios", [])]
        cells.append(f"{min(ratios):.2f} {np.median(ratios):.2f} {max(ratios):.2f}" if ratios else "–")
        cells += [_mean(chosen, "near"), _mean(chosen, "covered"), _mean(chosen, "drives"), _said(chosen)]
    return cells


def _mean(records: Sequence[Record], key: str) -> str:
    values = [record[key] for record in records if key in record]
    return f"{100 * np.mean(values):.0f} %" if values else "–"


def _said(records: Sequence[Record]) -> str:
    said = {
        "little excitation": sum("excitation" in " ".join(record.get("remarks", [])) for record in records),
        "refused": sum("refused" in record for record in records),
        "traceback": sum("failed" in record for record in records),
    }
    return counted(said)


def worst(records: Sequence[Record], count: int = 10) -> str:
    """Markdown: where the served curve was near the truth least often."""
    judged_ones = sorted((record for record in records if "near" in record), key=lambda record: record["near"])
    rows = [
        [
            record["policy"],
            f"{record['kind']} {record['vehicle']} {record['seed']}",
            record["circumstance"],
            f"{100 * record['near']:.0f} %",
            " … ".join(f"{rate:.3f}" for rate in record["trained_range"]),
            f"{record['driven_rates'][0]:.3f} … {record['driven_rates'][-1]:.3f}",
        ]
        for record in judged_ones[:count]
        if record["near"] < 1.0
    ]
    head = ["policy", "mission", "log", "near", "trained range [rad/s]", "driven rates [rad/s]"]
    return table(head, rows) if rows else "None."
