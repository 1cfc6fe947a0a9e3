"""A whole vehicle identified: measured ones beside pysindy and each axis by itself, simulated ones beside the truth.

The measured splits are those of `benchmarks.vehicles.splits`, both ways. Simulated vehicles are drawn by their seeds.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Mapping, Sequence
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.tables import interval, page, table

from benchmarks.study import MEASURED, begin, in_processes, options
from incsvr.numerics import Array, Streams
from incsvr.plant.axes import AXES, EFFORTS
from incsvr.vehicle import Identified, WholeMotion, identify, on_grid
from service.recordings.recording_csv import read
from simulator.six_degrees import BODIES, NAMES, Body, swim_together

SPLITS = {
    "dagon": ("run_{}", ("01", "03", "05", "07"), ("04",), {}),
    "blueboat": ("run_{}", ("220", "221", "224", "225"), ("230", "233", "234"), {}),
    "kvlcc2": (
        "Z_{}",
        ("05_01", "10_10_P", "20_10_S", "35_05"),
        ("10_05", "15_05", "25_05"),
        {"thrust": "surge_force"},
    ),
}
"""Vehicle → the names of its recordings, both halves, and columns that are called otherwise."""
AHEAD_S = 5.0
"""How far ahead predictions are compared [s]."""
THRESHOLDS = (0.0, 0.02, 0.05, 0.1, 0.2)
"""Thresholds of pysindy's STLSQ, in deviations; the one that predicts the fitted recordings best is taken."""


def measured(case: tuple[str, bool]) -> dict[str, Any]:
    """One split of a measured vehicle."""
    vehicle, flipped = case
    pattern, one, other, called = SPLITS[vehicle]
    first, second = (other, one) if flipped else (one, other)
    motion = on_grid(_streams(vehicle, pattern, first, called))
    unseen = on_grid(_streams(vehicle, pattern, second, called), motion.step)
    found = identify(motion, unseen, name=vehicle)
    return {
        "split": f"{vehicle}: {', '.join(first)} → {', '.join(second)}",
        "errors": _errors(found),
        "pysindy": dict(zip(found.vehicle.axes, sindy(motion, unseen, found.vehicle.axes), strict=True)),
        "mass": {one: found.vehicle.mass[one, one].value for one in found.vehicle.axes},
    }


def simulated(case: tuple[str, int, int, float, float]) -> list[dict[str, Any]]:
    """Simulated vehicles of a kind: of each what is known of its parameters."""
    kind, seed, each, seconds, speed = case
    rng = np.random.default_rng(seed)
    bodies = [BODIES[kind](rng) for _ in range(each)]
    towards = rng.uniform(0.0, 2.0 * np.pi) if speed else 0.0
    logs = swim_together(bodies, seconds, rng, (speed * np.cos(towards), speed * np.sin(towards)))
    return [known(kind, body, identify(on_grid([log]), validate=False)) for body, log in zip(bodies, logs, strict=True)]


def known(kind: str, body: Body, found: Identified) -> dict[str, Any]:
    """Whether each parameter's interval holds the truth."""
    rows = []
    for (one, other), parameter in found.vehicle.mass.items():
        truth = float(body.mass[NAMES.index(one), NAMES.index(other)])
        rows.append(("inertia" if one == other else "coupled inertia", truth, parameter))
    for term, parameter in found.vehicle.terms.items():
        there = {"linear": body.linear[term.row], "quadratic": body.quadratic[term.row], "righting": body.righting}
        rows.append((term.kind if term.kind in there else "not there", float(there.get(term.kind, 0.0)), parameter))
    return {
        "kind": kind,
        "rows": [
            {"what": what, "held": p.low <= truth <= p.high, "ratio": p.value / truth if truth else None,
             "origin": p.origin}
            for what, truth, p in rows
        ],
    }  # fmt: skip


def sindy(motion: WholeMotion, unseen: WholeMotion, axes: Sequence[str]) -> list[float]:
    """RMS errors of pysindy some seconds ahead, all axes at once: 1, x, x|x| and x y of velocities and efforts."""
    import pysindy

    rows = [list(AXES).index(name) for name in axes]
    driven = [k for k, name in enumerate(EFFORTS) if name in motion.recorded]
    size = np.concatenate([motion.velocity[:, rows].std(axis=0), motion.effort[:, driven].std(axis=0) + 1e-12])

    def features(values: Array) -> Array:
        pairs = [values[..., a] * values[..., b] for a, b in combinations_with_replacement(range(values.shape[-1]), 2)]
        signed = [values[..., k] * np.abs(values[..., k]) for k in range(values.shape[-1])]
        return np.stack([np.ones_like(values[..., 0]), *np.moveaxis(values, -1, 0), *pairs, *signed], axis=-1)

    def scaled(part: WholeMotion, cells: Any, velocity: Array) -> Array:
        return np.asarray(np.concatenate([velocity, part.effort[cells][..., driven]], axis=-1) / size)

    columns, rises = [], []
    for run in motion.runs:
        velocity = motion.velocity[run][:, rows]
        columns.append(features(scaled(motion, run, velocity)))
        rises.append(np.gradient(velocity, motion.step, axis=0) / size[: len(rows)])
    library, rise = np.concatenate(columns), np.concatenate(rises)

    def ahead(weights: Array, part: WholeMotion) -> Array:
        cells = max(1, round(AHEAD_S / part.step))
        first = part.windows(cells)
        velocity = part.velocity[first][:, rows]
        limit = 5.0 * np.abs(part.velocity[:, rows]).max(axis=0)
        for cell in range(cells):
            for _ in range(2):
                slope = features(scaled(part, first + cell, velocity)) @ weights.T * size[: len(rows)]
                velocity = np.clip(np.nan_to_num(velocity + 0.5 * part.step * slope), -limit, limit)
        return np.asarray(np.sqrt(np.mean((velocity - part.velocity[first + cells][:, rows]) ** 2, axis=0)))

    best = None
    for threshold in THRESHOLDS:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # it warns where it selects nothing, which here is an answer
            weights = pysindy.STLSQ(threshold=threshold, alpha=1e-6).fit(library, rise).coef_
        error = float(np.sum(ahead(weights, motion) / size[: len(rows)]))
        if best is None or error < best[0]:
            best = error, weights
    assert best is not None
    return [float(value) for value in ahead(best[1], unseen)]


def main(words: Sequence[str] | None = None) -> int:
    parser = options(
        "benchmarks.vehicles.whole_vehicle", __doc__ or "",
        first_seed=(3_000_000, "seed of the first kind of simulated vehicles; the others' follow"),
        each=(8, "simulated vehicles of each kind"), seconds=(600.0, "length of a simulated dive [s]"),
        current=(0.0, "speed of the water in which simulated vehicles move [m/s]; its direction is drawn"),
        processes=(2, "processes"),
    )  # fmt: skip
    args, when = begin(parser, words, "pysindy")
    there = [vehicle for vehicle in SPLITS if (MEASURED / vehicle).is_dir() and not args.current]
    splits = [(vehicle, flipped) for vehicle in there for flipped in (False, True)]
    cases = [(kind, args.first_seed + k, args.each, args.seconds, args.current) for k, kind in enumerate(BODIES)]
    real = in_processes(measured, splits, "splits", args.processes)
    drawn = [each for kind in in_processes(simulated, cases, "kinds", args.processes) for each in kind]
    made = f"Made by `{when['command']}` on {when['date']}, {when['processor']}."
    words_of_page = text(real, drawn, made)
    name = "whole_vehicle_in_current.md" if args.current else "whole_vehicle.md"
    (args.out / name).write_text(words_of_page, encoding="utf-8")
    print(words_of_page, end="")
    return 0


def text(real: Sequence[dict[str, Any]], drawn: Sequence[dict[str, Any]], made: str) -> str:
    """The page."""
    rows = [
        [each["split"], axis, *(f"{value:.3g}" for value in (e["model"], e["alone"], each["pysindy"][axis], e["hold"])),
         f"{each['mass'][axis]:.4g}"]
        for each in real for axis, e in each["errors"].items()
    ]  # fmt: skip
    head = ["split", "axis", "whole", "axis by itself", "pysindy", "held", "inertia"]
    every = [{**row, "kind": each["kind"]} for each in drawn for row in each["rows"] if row["origin"] == "estimated"]
    every += [{**row, "kind": "all"} for row in every if row["what"] != "not there"]
    groups = dict.fromkeys((row["kind"], row["what"]) for row in every)
    groups |= dict.fromkeys([("all", "together")] if every else [])
    truth = []
    for kind, what in groups:
        own = [row for row in every if row["kind"] == kind and what in (row["what"], "together")]
        held = sum(row["held"] for row in own)
        low, high = interval(held, len(own))
        ratios = [row["ratio"] for row in own if row["ratio"] is not None]
        truth.append([kind, what, f"{held} of {len(own)} ({100 * low:.0f}–{100 * high:.0f} %)",
                      f"{np.median(ratios):.3f}" if ratios else "–"])  # fmt: skip
    return page(
        "# A whole vehicle identified", made,
        f"Errors are RMS, {AHEAD_S:g} s ahead, on dives that were not fitted [m/s], [rad/s].",
        "## Measured vehicles", table(head, rows),
        "## Simulated vehicles: does the interval of 95 % hold the truth",
        table(["kind", "parameter", "held", "median ratio"], truth),
    )  # fmt: skip


def _errors(found: Identified) -> dict[str, dict[str, float]]:
    model, hold, _ = found.errors.horizons[AHEAD_S]
    alone = [float(found.by_itself[axis].horizons[AHEAD_S][0][0]) for axis in found.errors.axes]
    return {
        axis: {"model": float(m), "alone": a, "hold": float(h)}
        for axis, m, a, h in zip(found.errors.axes, model, alone, hold, strict=True)
    }


def _streams(vehicle: str, pattern: str, names: Sequence[str], called: Mapping[str, str]) -> list[Streams]:
    runs = [read(Path(MEASURED) / vehicle / f"{pattern.format(name)}.csv") for name in names]
    return [{called.get(name, name): stream for name, stream in run.streams().items()} for run in runs]


if __name__ == "__main__":
    sys.exit(main())
