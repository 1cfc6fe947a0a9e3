"""Is the model worth its name while the gyro is silent? Forecasts of yaw rate and heading at 1, 5, 20 and 60 s.

Each recording is learned online, batch by batch, as on board. In its second half forecasts start at five instants of
each batch, with the model and the experience that were there, and see the recorded torque alone. Beside them stand who
holds the last rate, and dead reckoning with the textbook's N_r r + N_{r|r|} r|r| by least squares over all samples
until then; both get the interval of what 95 % of their own errors at that horizon have been until then.

    python -m benchmarks.learner.forecast
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.study import RESULTS, provenance
from benchmarks.tables import share, table
from incsvr.checks import Vehicle
from incsvr.errors import BadInput
from incsvr.forecasting import Experience, Grid, Start, forecast
from incsvr.forecasting.experience import CLAIM, KEPT, widening
from incsvr.forecasting.experience import HORIZONS as TRIED
from incsvr.free_run.integrator import free_run, tabulated
from incsvr.learning import guarded
from incsvr.learning.baselines import Data, LeastSquares
from incsvr.numerics import Array, root_mean_square
from incsvr.signals import TORQUE, YAW_RATE
from incsvr.signals.settings import COMMANDED
from service.cli.progress import progress
from service.recordings.recording import Recording, sequence
from service.recordings.recording_csv import RATE_LIMIT, read
from service.recordings.samples_from_recording import learner_for, samples_of, signals_for
from service.wire.json_text import json_text
from simulator import leng
from simulator.missions import Mission, play

HORIZONS = (1.0, 5.0, 20.0, 60.0)
"""[s]"""
STARTS = 5
"""Of a batch."""
METHODS = ("learner", "hold", "least squares")
MISSIONS = (("survey", "auv"), ("survey", "rov"), ("waypoints", "auv"), ("circles", "rov"), ("survey", "leng"))
"""What is simulated: at work, with the controller in the loop."""
MEASURED = {"bluerov": 1.125, "dagon": 800.0, "blueboat": 25.65, "kvlcc2": 16_100.0}
"""Vehicles that were measured, and what was published of their inertia, in the units of their torque."""
METHOD = " ".join(__doc__.split("\n\n")[1].split())


@dataclass(frozen=True, slots=True)
class Case:
    """A recording to learn and to forecast: a vehicle that was measured, or a mission, or the Leng's training run."""

    name: str
    seed: int | None
    kind: str = ""
    vehicle: str = ""
    folder: Path | None = None


@dataclass(frozen=True, slots=True)
class Truth:
    """What really happened: times (n,), yaw rate (n,), heading (n,) counted on."""

    time: Array
    rate: Array
    heading: Array


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.learner.forecast", description=__doc__)
    parser.add_argument("--first-seed", type=int, default=810_000)
    parser.add_argument("--seeds", type=int, default=4, help="missions of each kind (default 4)")
    parser.add_argument("--minutes", type=float, default=30.0, help="how long a mission is (default 30)")
    parser.add_argument("--measured", type=Path, default=Path("../shared/measured"), help="folder of measured runs")
    parser.add_argument("--policy", choices=("paper", "weighted"), default="paper")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=RESULTS / "forecast.md")
    args = parser.parse_args(arguments)
    command = " ".join(
        ["python -m benchmarks.learner.forecast", *(arguments if arguments is not None else sys.argv[1:])]
    )
    about, records = provenance(command), study(args)
    args.out.write_text(report(about, records), encoding="utf-8")
    rows = json_text({**about, "rows": condensed(records)}, indent=1)
    args.out.with_suffix(".json").write_text(rows + "\n", encoding="utf-8")
    print(args.out.read_text(encoding="utf-8"))
    return 0


def study(args: argparse.Namespace) -> list[dict[str, Any]]:
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    work = [
        (Case(f"{kind}, {vehicle}", args.first_seed + number, kind, vehicle), 60.0 * args.minutes, args.policy)
        for kind, vehicle in MISSIONS
        for number in range(args.seeds)
    ]
    work += [(Case("open loop, leng", args.first_seed + number), 0.0, args.policy) for number in range(args.seeds)]
    work += [
        (Case(f"measured, {name}", None, vehicle=name, folder=args.measured), 0.0, args.policy)
        for name in MEASURED
        if (args.measured / name).is_dir()
    ]
    records: list[dict[str, Any]] = []
    with (
        ProcessPoolExecutor(args.processes, multiprocessing.get_context("spawn")) as pool,
        progress("recordings", len(work)) as advance,
    ):
        for found in pool.map(examine, *zip(*work, strict=True)):
            records += found
            advance()
    return records


def examine(case: Case, duration: float, policy: str) -> list[dict[str, Any]]:
    """A record for each forecast of a recording: case, horizon, method, errors and half intervals."""
    recording, inertia, truth = _played(case, duration)
    signals = signals_for([recording], inertia, RATE_LIMIT)
    try:
        samples, _ = samples_of(recording, signals, None)
        settings = learner_for(samples, policy=policy)
    except BadInput as refusal:
        return [{"case": case.name, "refused": str(refusal)}]
    streams, size = recording.streams(), settings.batch
    held = signals.torque == COMMANDED
    whole = Grid.of(streams[YAW_RATE], streams[TORQUE], signals.smoothing, signals.sample_period, held)
    truth = truth or _measured(whole)
    vehicle = Vehicle(inertia, settings.rate_range, signals.smoothing, believed=False)
    state, experience = guarded.begin(settings), Experience()
    past: dict[tuple[str, float], list[tuple[float, float, float, float]]] = {}
    records = []
    half_way = 0.5 * (samples.time[0] + samples.time[-1])
    for first in range(0, len(samples) - size + 1, size):
        batch = samples.take(slice(first, first + size))
        model = state.learner.model
        if model.is_trained:
            textbook = LeastSquares().fit(Data.of(samples.take(slice(0, first)), streams[YAW_RATE], streams[TORQUE]))
            table_ = tabulated(textbook.predict, 2.5 * experience.fastest)
            for place in np.linspace(0, size - 1, STARTS, endpoint=False).astype(int).tolist():
                node = int(np.searchsorted(whole.time, batch.time[place]))
                if node >= whole.time.size or not np.isfinite(whole.rate[node]):
                    continue
                start = Start(float(whole.time[node]), float(whole.rate[node]))
                for horizon in HORIZONS:
                    end = start.time + horizon
                    ahead = slice(node, node + round(horizon / whole.step) + 1)
                    stamps, moment = whole.time[ahead], whole.torque[ahead]
                    if stamps[-1] < end - whole.step or not np.isfinite(moment + whole.rate[ahead]).all():
                        continue
                    rate = float(np.interp(end, truth.time, truth.rate))
                    turned = float(np.diff(np.interp([start.time, end], truth.time, truth.heading))[0])
                    said = forecast(
                        experience,
                        model,
                        inertia,
                        start,
                        (stamps, moment),
                        np.array([end]),
                        step=whole.step,
                        sample_period=signals.sample_period,
                    )
                    run = free_run(stamps, moment, start.rate, inertia=inertia, damping=table_)
                    run = np.where(np.isfinite(run), run, 2.5 * experience.fastest)  # it ran away
                    own = 0.5 * float(np.sum((run[1:] + run[:-1]) * np.diff(stamps)))
                    told = {
                        "learner": (float(said.rate[0]), float(said.turned[0])),
                        "hold": (start.rate, start.rate * horizon),
                        "least squares": (float(run[-1]), own),
                    }
                    for method, (r, psi) in told.items():
                        errors = past.setdefault((method, horizon), [])
                        halves = (float(said.rate_half[0]), float(said.turned_half[0]))
                        if method != "learner":
                            halves = _of_errors([e[1:] for e in errors if e[0] <= start.time], horizon)
                        errors.append((end, float(batch.time[-1]), abs(r - rate), abs(psi - turned)))
                        if start.time >= half_way:
                            records.append(
                                {
                                    "case": case.name, "horizon": horizon, "method": method,
                                    "rate_error": r - rate, "rate_half": halves[0],
                                    "turned_error": psi - turned, "turned_half": halves[1],
                                    "worth": bool(said.worth[0]),
                                }
                            )  # fmt: skip
        state, verdict, _ = guarded.learn(settings, vehicle, state, batch)
        if verdict.learn:
            newest = (whole.time >= batch.time[0] - TRIED[-1]) & (whole.time <= batch.time[-1])
            experience = experience.after(model, inertia, whole.part(newest))
    return records


def _played(case: Case, duration: float) -> tuple[Recording, float, Truth | None]:
    if case.folder is not None:
        runs = [read(path, rate_limit=RATE_LIMIT) for path in sorted((case.folder / case.vehicle).glob("*.csv"))]
        kept = [replace(run, columns={name: run.columns[name] for name in (YAW_RATE, TORQUE)}) for run in runs]
        return sequence(kept), MEASURED[case.vehicle], None
    assert case.seed is not None
    if not case.kind:
        return leng.recording("T1", case.seed), leng.INERTIA, None
    outcome = play(Mission(case.kind, case.vehicle, case.seed, duration=duration))
    motion = outcome.motion
    return outcome.recording, outcome.inertia, Truth(motion.time, motion.yaw_rate, motion.heading)


def _measured(whole: Grid) -> Truth:
    """The gyro itself, in means over half a width of the learner's filter, where nobody knows better."""
    known = np.isfinite(whole.rate)
    rate = np.interp(whole.time, whole.time[known], whole.rate[known])
    return Truth(whole.time, rate, np.concatenate(([0.0], np.cumsum(0.5 * whole.step * (rate[1:] + rate[:-1])))))


def _of_errors(errors: Sequence[tuple[float, float, float]], horizon: float) -> tuple[float, float]:
    """Half of the interval that 95 % of earlier errors were within; infinite before there are any."""
    if not errors:
        return float("inf"), float("inf")
    rate, turned = widening(np.array(errors[-KEPT:]), horizon)
    return rate * CLAIM, turned * CLAIM


def condensed(records: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """A row for each case, horizon and method."""
    rows = []
    for case in dict.fromkeys(record["case"] for record in records):
        for horizon in HORIZONS:
            for method in METHODS:
                own = [r for r in records if (r["case"], r.get("horizon"), r.get("method")) == (case, horizon, method)]
                if own:
                    rows.append({"case": case, "horizon": horizon, "method": method} | _figures(own))
    return rows


def _figures(own: Sequence[dict[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {"forecasts": len(own)}
    for which in ("rate", "turned"):
        error = np.array([record[f"{which}_error"] for record in own])
        half = np.array([record[f"{which}_half"] for record in own])
        found |= {
            f"{which}_rmse": root_mean_square(error),
            f"{which}_covered": int(np.sum(np.abs(error) <= half)),
            f"{which}_half": float(np.median(half)) if np.isfinite(np.median(half)) else None,
        }
    return found | {"worth": float(np.mean([record["worth"] for record in own]))}


def report(about: dict[str, object], records: Sequence[dict[str, Any]]) -> str:
    """Markdown."""
    rows = condensed(records)
    parts = [
        "# The model as a stand-in for the gyro",
        f"Made by `{about['command']}` on {about['date']}. {METHOD}",
        "Truth is the simulated motion; of measured vehicles and of Leng's open loop it is the gyro, in means over "
        "half a width of the filter. Covered: how many intervals of 95 % hold it, with Wilson's interval (forecasts of "
        "one recording are not independent: it is too narrow). Half: the median half width. Worth: where the learner's "
        "interval is narrower than what the vehicle's rates are usually within.",
    ]
    for which, title, unit in (("rate", "Yaw rate", "rad/s"), ("turned", "Heading", "rad")):
        lines = []
        for case in dict.fromkeys(row["case"] for row in rows):
            for horizon in HORIZONS:
                own = {row["method"]: row for row in rows if (row["case"], row["horizon"]) == (case, horizon)}
                if own:
                    cells: list[object] = [case, f"{horizon:g} s", own["learner"]["forecasts"]]
                    for method in METHODS:
                        row = own[method]
                        half = row[f"{which}_half"]
                        cells += [
                            share(row[f"{which}_covered"], row["forecasts"]),
                            f"{row[f'{which}_rmse']:.3g}, {'–' if half is None else f'{half:.3g}'}",
                        ]
                    lines.append([*cells, f"{100 * own['learner']['worth']:.0f} %"])
        head = ["case", "ahead", "n"]
        for method in METHODS:
            head += [f"{method}: covered", f"RMSE, half [{unit}]"]
        parts += [f"## {title}", table([*head, "worth"], lines)]
    refused = [record for record in records if "refused" in record]
    parts += [f"{record['case']}: {record['refused']}" for record in refused]
    return "\n\n".join(parts) + "\n"


if __name__ == "__main__":
    sys.exit(main())
