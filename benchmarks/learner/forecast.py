"""Is the model worth its name while the gyro is silent? Forecasts of yaw rate and heading at 1, 5, 20 and 60 s.

Each recording is learned online, batch by batch, as on board. In its second half forecasts start at five instants of
each batch, with the model and the experience that were there, and see the recorded torque alone. Beside them stand who
holds the last rate, and dead reckoning with the textbook's N_r r + N_{r|r|} r|r| by least squares over all samples
until then; both get the interval of what 95 % of their own errors at that horizon have been until then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from benchmarks.learner.policies import batches
from benchmarks.paper.baselines import Data, LeastSquares
from benchmarks.study import CORES, MEASURED, Record, begin, in_processes, options, publish
from benchmarks.tables import grouped, page, share, table
from incsvr.checks import Vehicle
from incsvr.errors import BadInput
from incsvr.forecasting import Experience, Forecast, Grid, Start, forecast
from incsvr.forecasting.experience import HORIZON_ERRORS, NORMAL_95_DEVIATIONS, widening
from incsvr.forecasting.experience import HORIZONS_S as TRIED
from incsvr.free_run.integrator import Damping, free_run, tabulated
from incsvr.learning import checked_learner
from incsvr.learning.model import Model
from incsvr.numerics import Array, root_mean_square
from incsvr.signals import TORQUE, YAW_RATE
from incsvr.signals.samples import Samples
from incsvr.signals.settings import COMMANDED
from service.recordings.recording import Recording, sequence
from service.recordings.recording_csv import RATE_LIMIT, read
from service.recordings.samples_from_recording import learner_for, samples_of, signals_for
from simulator import leng
from simulator.missions import Mission, play

HORIZONS = (1.0, 5.0, 20.0, 60.0)
"""[s]"""
STARTS_PER_BATCH = 5
"""Instants of each batch from which forecasts start."""
METHODS = ("learner", "hold", "least squares")
MISSIONS = (("survey", "auv"), ("survey", "rov"), ("waypoints", "auv"), ("circles", "rov"), ("survey", "leng"))
"""What is simulated: at work, with the controller in the loop."""
INERTIAS = {"bluerov": 1.125, "dagon": 800.0, "blueboat": 25.65, "kvlcc2": 16_100.0}
"""Vehicles that were measured, and what was published of their inertia, in the units of their torque."""
METHOD = " ".join(__doc__.split("\n\n")[1].split())


@dataclass(frozen=True, slots=True)
class Case:
    """A recording to learn and to forecast: a vehicle that was measured, or a mission, or the Leng's training run."""

    name: str
    seed: int | None
    kind: str = ""
    vehicle: str = ""


@dataclass(frozen=True, slots=True)
class Truth:
    """What really happened: times (n,), yaw rate (n,), heading (n,) counted on."""

    time: Array
    rate: Array
    heading: Array


def examine(work: tuple[Case, float]) -> list[Record]:
    """A record for each forecast of a recording: case, horizon, method, errors and half intervals."""
    case, duration = work
    recording, inertia, truth = _played(case, duration)
    signals = signals_for([recording], inertia, RATE_LIMIT)
    try:
        samples, _ = samples_of(recording, signals, None)
        settings = learner_for(samples, policy="paper")
    except BadInput as refusal:
        return [{"case": case.name, "refused": str(refusal)}]
    streams = recording.streams()
    held = signals.torque == COMMANDED
    whole = Grid.of(streams[YAW_RATE], streams[TORQUE], signals.smoothing, signals.sample_period, held)
    contest = Contest(case.name, inertia, whole, truth or _measured(whole), signals.sample_period)
    vehicle = Vehicle(inertia, settings.rate_range, signals.smoothing)
    state, experience = checked_learner.begin(settings), Experience()
    for number, batch in enumerate(batches(samples, settings.batch)):
        model = state.learner.model
        if model.is_trained:
            past = samples.take(slice(0, number * settings.batch))
            textbook = LeastSquares().fit(Data.of(past, streams[YAW_RATE], streams[TORQUE]))
            contest.over(batch, model, experience, tabulated(textbook.predict, 2.5 * experience.fastest))
        state, verdict, _ = checked_learner.learn(settings, vehicle, state, batch)
        if verdict.learn:
            newest = (whole.time >= batch.time[0] - TRIED[-1]) & (whole.time <= batch.time[-1])
            experience = experience.after(model, inertia, whole.part(newest))
    half_way = 0.5 * (samples.time[0] + samples.time[-1])
    return [record for record in contest.records if record["start"] >= half_way]


class Contest:
    """The methods' forecasts on one recording, and the errors that each has made so far."""

    def __init__(self, name: str, inertia: float, whole: Grid, truth: Truth, sample_period: float) -> None:
        self.name, self.inertia, self.whole, self.truth = name, inertia, whole, truth
        self.sample_period = sample_period
        self.records: list[Record] = []
        self._past: dict[tuple[str, float], list[tuple[float, float, float, float]]] = {}

    def over(self, batch: Samples, model: Model, experience: Experience, textbook: Damping) -> None:
        """Forecasts from five instants of a batch with what was learned before it."""
        whole = self.whole
        for place in np.linspace(0, len(batch) - 1, STARTS_PER_BATCH, endpoint=False).astype(int).tolist():
            node = int(np.searchsorted(whole.time, batch.time[place]))
            if node >= whole.time.size or not np.isfinite(whole.rate[node]):
                continue
            start = Start(float(whole.time[node]), float(whole.rate[node]))
            for horizon in HORIZONS:
                ahead = slice(node, node + round(horizon / whole.step) + 1)
                stamps, moment = whole.time[ahead], whole.torque[ahead]
                reaches = stamps[-1] >= start.time + horizon - whole.step
                if not reaches or not np.isfinite(moment + whole.rate[ahead]).all():
                    continue
                said = forecast(
                    experience, model, self.inertia, start, (stamps, moment), np.array([start.time + horizon]),
                    step=whole.step, sample_period=self.sample_period,
                )  # fmt: skip
                run = free_run(stamps, moment, start.rate, inertia=self.inertia, damping=textbook)
                run = np.where(np.isfinite(run), run, 2.5 * experience.fastest)  # it ran away
                self._judge(start, horizon, said, run, stamps, float(batch.time[-1]))

    def _judge(self, start: Start, horizon: float, said: Forecast, run: Array, stamps: Array, known: float) -> None:
        """Records the errors of each method over a horizon; `known` is the time of the batch's last sample [s]."""
        end, truth = start.time + horizon, self.truth
        rate = float(np.interp(end, truth.time, truth.rate))
        turned = float(np.diff(np.interp([start.time, end], truth.time, truth.heading))[0])
        answers = {
            "learner": (float(said.rate[0]), float(said.turned[0])),
            "hold": (start.rate, start.rate * horizon),
            "least squares": (float(run[-1]), 0.5 * float(np.sum((run[1:] + run[:-1]) * np.diff(stamps)))),
        }
        for method, (r, psi) in answers.items():
            errors = self._past.setdefault((method, horizon), [])
            halves = (float(said.rate_half[0]), float(said.turned_half[0]))
            if method != "learner":
                halves = _of_errors([e[1:] for e in errors if e[0] <= start.time], horizon)
            errors.append((end, known, abs(r - rate), abs(psi - turned)))
            self.records.append({
                "case": self.name, "start": start.time, "horizon": horizon, "method": method,
                "rate_error": r - rate, "rate_half": halves[0],
                "turned_error": psi - turned, "turned_half": halves[1],
                "worth": bool(said.worth[0]),
            })  # fmt: skip


def _played(case: Case, duration: float) -> tuple[Recording, float, Truth | None]:
    if case.seed is None:
        runs = [read(path, rate_limit=RATE_LIMIT) for path in sorted((MEASURED / case.vehicle).glob("*.csv"))]
        kept = [replace(run, columns={name: run.columns[name] for name in (YAW_RATE, TORQUE)}) for run in runs]
        return sequence(kept), INERTIAS[case.vehicle], None
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
    rate, turned = widening(np.array(errors[-HORIZON_ERRORS:]), horizon)
    return rate * NORMAL_95_DEVIATIONS, turned * NORMAL_95_DEVIATIONS


def condensed(records: Sequence[Record]) -> list[Record]:
    """A row for each case, horizon and method."""
    return [
        {"case": case, "horizon": horizon, "method": method} | _figures(own)
        for case, of_case in grouped([record for record in records if "refused" not in record], "case").items()
        for horizon, ahead in sorted(grouped(of_case, "horizon").items())
        for method, own in grouped(ahead, "method").items()
    ]


def _figures(own: Sequence[Record]) -> Record:
    found: Record = {"forecasts": len(own)}
    for which in ("rate", "turned"):
        error = np.array([record[f"{which}_error"] for record in own])
        half = np.array([record[f"{which}_half"] for record in own])
        found |= {
            f"{which}_rmse": root_mean_square(error),
            f"{which}_covered": int(np.sum(np.abs(error) <= half)),
            f"{which}_half": float(np.median(half)) if np.isfinite(np.median(half)) else None,
        }
    return found | {"worth": float(np.mean([record["worth"] for record in own]))}


def report(document: Record) -> str:
    """Markdown."""
    return page(
        "# The model as a stand-in for the gyro",
        f"Made by `{document['command']}` on {document['date']}. {METHOD}",
        "Truth is the simulated motion; of measured vehicles and of Leng's open loop it is the gyro, in means over "
        "half a width of the filter. Covered: how many intervals of 95 % hold it, with Wilson's interval (forecasts of "
        "one recording are not independent: it is too narrow). Half: the median half width. Worth: where the learner's "
        "interval is narrower than what the vehicle's rates are usually within.",
        "## Yaw rate",
        _table(document["rows"], "rate", "rad/s"),
        "## Heading",
        _table(document["rows"], "turned", "rad"),
        *document["refused"],
    )


def _table(rows: Sequence[Record], which: str, unit: str) -> str:
    lines: list[list[object]] = []
    for case, of_case in grouped(rows, "case").items():
        for horizon, own in grouped(of_case, "horizon").items():
            cells: list[object] = [case, f"{horizon:g} s", own[0]["forecasts"]]
            for row in own:
                half = "–" if row[f"{which}_half"] is None else f"{row[f'{which}_half']:.3g}"
                cells += [share(row[f"{which}_covered"], row["forecasts"]), f"{row[f'{which}_rmse']:.3g}, {half}"]
            lines.append([*cells, f"{100 * own[0]['worth']:.0f} %"])
    heads = [head for method in METHODS for head in (f"{method}: covered", f"RMSE, half [{unit}]")]
    return table(["case", "ahead", "n", *heads, "worth"], lines)


def main(words: Sequence[str] | None = None) -> None:
    parser = options(
        "benchmarks.learner.forecast",
        __doc__,
        first_seed=(810_000, "of the missions"),
        seeds=(4, "missions of each kind"),
        minutes=(30.0, "how long a mission is"),
        processes=(CORES, "recordings at once"),
    )
    args, measured = begin(parser, words)
    seeds = range(args.first_seed, args.first_seed + args.seeds)
    cases = [Case(f"{kind}, {vehicle}", seed, kind, vehicle) for kind, vehicle in MISSIONS for seed in seeds]
    cases += [Case("open loop, leng", seed) for seed in seeds]
    cases += [Case(f"measured, {name}", None, vehicle=name) for name in INERTIAS if (MEASURED / name).is_dir()]
    work = [(case, 60.0 * args.minutes) for case in cases]
    records = list(chain.from_iterable(in_processes(examine, work, "recordings", args.processes)))
    document = measured | {
        "rows": condensed(records),
        "refused": [f"{record['case']}: {record['refused']}" for record in records if "refused" in record],
    }
    publish(args.out, "forecast", document, report(document))


if __name__ == "__main__":
    main()
