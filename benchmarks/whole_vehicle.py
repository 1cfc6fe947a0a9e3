"""A whole vehicle identified: simulated ones beside the truth, measured ones on dives that were not fitted.

Simulated vehicles of three kinds are drawn by their seeds and driven by commands that hold, in still water and in a
current of 0.15 m/s. Of measured ones, the errors are RMS 5 s ahead, the same with each axis by itself and with the last
velocity held.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence

import numpy as np

from benchmarks.study import HALVES, MEASURED, Record, grouped, run, seeds, share, table
from incsvr.vehicle import Identified, identify
from service.recordings.reading import read
from simulator.dive_log import dives
from simulator.vehicles import BODIES, NAMES, Vehicle

CALLED = {"thrust": "surge_force"}
"""Columns that are called otherwise."""
AHEAD_S = 5.0
CURRENT_M_S = 0.15
Case = tuple[str, str, int, float]
"""Kind of case, vehicle, seed or which half is fitted, length [s]."""


def examine(case: Case) -> Record:
    """A simulated vehicle, or a split of a measured one."""
    what, name, number, seconds = case
    if what == "measured":
        return _measured(name, bool(number))
    random = np.random.default_rng(number)
    vehicle, towards = BODIES[name](random), random.uniform(0.0, 2.0 * np.pi)
    speed = CURRENT_M_S if what == "in a current" else 0.0
    (log,) = dives([vehicle], seconds, number, (speed * np.cos(towards), speed * np.sin(towards)))
    return {
        "what": what,
        "vehicle": name,
        "seed": number,
        "rows": known(vehicle, identify([log], validate=False)),
    }


def known(vehicle: Vehicle, found: Identified) -> list[Record]:
    """Whether the interval of each parameter that was estimated contains the truth."""
    rows = []
    for (one, other), parameter in found.vehicle.mass.items():
        truth = float(vehicle.mass[NAMES.index(one), NAMES.index(other)])
        rows.append(("inertia" if one == other else "coupled inertia", truth, parameter))
    for term, parameter in found.vehicle.terms.items():
        there = {
            "linear": vehicle.linear[term.row],
            "quadratic": vehicle.quadratic[term.row],
            "righting": vehicle.righting,
        }
        rows.append((term.kind if term.kind in there else "not there", float(there.get(term.kind, 0.0)), parameter))
    return [
        {"parameter": what, "inside": p.low <= truth <= p.high, "ratio": p.value / truth if truth else None}
        for what, truth, p in rows if p.origin == "estimated"
    ]  # fmt: skip


def _measured(vehicle: str, flipped: bool) -> Record:
    halves = HALVES[vehicle][::-1] if flipped else HALVES[vehicle]
    runs = [[read(MEASURED / vehicle / f"{name}.csv").streams() for name in names] for names in halves]
    fitted, unseen = ([{CALLED.get(k, k): stream for k, stream in each.items()} for each in own] for own in runs)
    found = identify(fitted, unseen, name=vehicle)
    model, hold, _ = found.errors.horizons[AHEAD_S]
    rows = [
        {"axis": axis, "whole": float(m), "alone": float(found.by_itself[axis].horizons[AHEAD_S][0][0]),
         "hold": float(h), "inertia": found.vehicle.mass[axis, axis].value}
        for axis, m, h in zip(found.errors.axes, model, hold, strict=True)
    ]  # fmt: skip
    return {"what": "measured", "split": f"{vehicle}: {' → '.join(', '.join(names) for names in halves)}", "rows": rows}


def report(records: Sequence[Record]) -> Iterable[str]:
    """How often intervals of 95 % contain the truth; then the measured vehicles."""
    drawn = [
        {"what": each["what"], "vehicle": each["vehicle"], **row}
        for each in records if each["what"] != "measured" for row in each["rows"]
    ]  # fmt: skip
    rows = [
        [what, vehicle, parameter, share(sum(row["inside"] for row in own), len(own)), _ratio(own)]
        for (what, vehicle, parameter), own in grouped(drawn, "what", "vehicle", "parameter").items()
    ]
    there = grouped([row for row in drawn if row["parameter"] != "not there"], "what")
    rows += [
        [what, "all", "all", share(sum(r["inside"] for r in own), len(own)), _ratio(own)] for what, own in there.items()
    ]
    yield table(["water", "vehicle", "parameter", "interval of 95 % contains the truth", "median ratio"], rows)
    real = [
        [each["split"], row["axis"], *(f"{row[key]:.3g}" for key in ("whole", "alone", "hold", "inertia"))]
        for each in records if each["what"] == "measured" for row in each["rows"]
    ]  # fmt: skip
    if real:
        yield table(["split", "axis", "whole", "axis by itself", "hold", "inertia"], real)


def _ratio(own: Sequence[Record]) -> str:
    ratios = [row["ratio"] for row in own if row["ratio"] is not None]
    return f"{np.median(ratios):.3f}" if ratios else "–"


def cases(asked: argparse.Namespace) -> list[Case]:
    """Measured splits both ways where the recordings are there, and simulated vehicles in both waters."""
    there = [name for name in HALVES if (MEASURED / name).is_dir()] if asked.measured else []
    real: list[Case] = [("measured", name, flipped, 0.0) for name in there for flipped in (0, 1)]
    waters = ("still water", "in a current")
    return real + [(what, name, seed, asked.seconds) for what in waters for name in BODIES for seed in seeds(asked)]


if __name__ == "__main__":
    run(
        "whole_vehicle", __doc__, cases, examine, report, first_seed=(3_000_000, "of the simulated vehicles"),
        seeds=(8, "simulated vehicles of each kind and water"), seconds=(600.0, "length of a simulated dive"),
        measured=(1, "whether the measured splits are examined, 0 or 1"),
    )  # fmt: skip
