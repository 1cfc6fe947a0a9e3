"""Every axis of every measured vehicle: what each method predicts of recordings that it was not fitted to.

`make vehicles`. The splits stand in splits.py. A free run simulates the velocity over each
unseen recording from its first value, from the force (torque) and the other recorded velocities alone; a multi-step
error is that at the end of a shorter run, all of which begin at measured velocities.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.paper.baselines import AdaptiveIdentifier, Baseline, Data, LeastSquares, RecursiveLeastSquares
from benchmarks.study import MEASURED, Record, begin, in_processes, options, publish
from benchmarks.vehicles.motion import Motion, Trivial
from benchmarks.vehicles.peers import frols, process, sindy
from benchmarks.vehicles.report import report
from benchmarks.vehicles.splits import SPLITS, Split, skipped
from benchmarks.vehicles.study_data import Material
from incsvr.effects import Signals, Term
from incsvr.errors import BadInput
from incsvr.numerics import Array, root_mean_square
from incsvr.plant.axes import VELOCITIES
from incsvr.plant.mass_and_coriolis import products
from incsvr.signals import TORQUE, YAW_RATE
from incsvr.tracing.findings import Trace
from incsvr.tracing.thresholds import HORIZON_SCALES
from service.commands.fit_alternatives import AS_GIVEN
from service.commands.fit_result import Fit
from service.commands.trace import trace_recordings
from service.recordings.recording import sequence
from service.recordings.samples_from_recording import samples_of, signals_for

SETTLING_RATIO = 30.0
"""Time constant of the adaptive identifier's coefficients, in those in which its copy follows, T_c (its own ratio)."""


def _baseline(method: Callable[[Material], Baseline]) -> Callable[[Material], Motion]:
    def fitted(given: Material) -> Motion:
        joined = sequence(given.fitted)
        samples, _ = samples_of(joined, signals_for(given.fitted, given.inertia, given.axis.fastest), None)
        streams = joined.streams()
        return given.curve(method(given).fit(Data.of(samples, streams[YAW_RATE], streams[TORQUE])).predict)

    return fitted


def _adaptive(given: Material) -> AdaptiveIdentifier:
    fast, scale = float(np.quantile(np.abs(given.there.rate), 0.99)), given.there.scale
    return AdaptiveIdentifier(given.inertia, fast, scale, SETTLING_RATIO * scale)


def _process(given: Material) -> Motion:
    joined = sequence(given.fitted)
    samples, _ = samples_of(joined, signals_for(given.fitted, given.inertia, given.axis.fastest), None)
    beside = [np.interp(samples.time, joined.time, joined.velocities[name]) for name in given.others]
    others = np.column_stack([np.empty((len(samples), 0)), *beside])
    return process(samples.yaw_rate, others, samples.damping, given.inertia, given.others)


def _learner(given: Material) -> Motion:
    signals = signals_for(given.fitted, given.inertia, given.axis.fastest)
    model = Fit.of(given.fitted, (), signals, None, {"policy": "paper"}, by_person=AS_GIVEN).iterations[-1].model
    return given.curve(lambda rate: model.predict(rate).damping)


def _learner_in_body(given: Material) -> Motion:
    """The learner's curve with C(ν)ν of the declared mass matrix beside it, as the terms of which it consists."""
    coupled = given.coupled
    assert coupled is not None
    signals = signals_for(given.fitted, given.inertia, given.axis.fastest)
    model = (
        Fit.of(given.fitted, (), signals, None, {"policy": "paper"}, coupled=coupled, by_person=AS_GIVEN)
        .iterations[-1]
        .model
    )
    weights = products(coupled.mass, VELOCITIES.index(given.axis.rate))
    terms = [
        Term(f"coriolis:{VELOCITIES[a]}*{VELOCITIES[b]}", "", (float(weights[a, b]),))
        for a, b in np.argwhere(weights != 0.0).tolist()
    ]
    return replace(given.curve(lambda rate: model.predict(rate).damping), terms=tuple(terms))


IN_BODY = "incsvr fit, M declared"
METHODS: Mapping[str, Callable[[Material], Motion]] = {
    "zero": lambda given: Trivial(0.0),
    "hold": lambda given: Trivial(1.0),
    "least squares": _baseline(lambda given: LeastSquares()),
    "recursive least squares": _baseline(lambda given: RecursiveLeastSquares()),
    "adaptive identifier": _baseline(_adaptive),
    "Gaussian process": _process,
    "pysindy": lambda given: sindy(given.there, given.others),
    "sysidentpy": lambda given: frols(given.there, given.others),
    "incsvr fit": _learner,
}
"""Each learns from a split's material what simulates the motion."""


def judged(learn: Callable[[Material], Motion], given: Material) -> Record:
    """Free-run and multi-step errors of a method on the unseen recordings [rad/s], or why there are none."""
    begun = time.process_time()
    try:
        model = learn(given)
        seconds = time.process_time() - begun
        here = given.here
        _, simulated = model.simulate(here)
        steps = [_ahead(model, here, horizon * given.there.scale) for horizon in HORIZON_SCALES]
    except BadInput as error:
        return {"failed": str(error), "seconds": time.process_time() - begun}
    except Exception as error:  # whatever a library says of a split that it cannot fit is the row's result
        return {"failed": f"{type(error).__name__}: {error}", "seconds": time.process_time() - begun}
    errors = zip(HORIZON_SCALES, steps, strict=True)
    return {
        "free_run": root_mean_square(simulated - here.rate),
        "ahead": {f"{horizon:g}": root_mean_square(error) if error.size else None for horizon, error in errors},
        "seconds": seconds,
    }


def _ahead(model: Motion, here: Signals, horizon: float) -> Array:
    """(m,) errors at the end of runs of this length [s], side by side [rad/s]."""
    steps = max(round(horizon / here.step), 1)
    spans = [slice(a, a + steps + 1) for run in here.runs() for a in range(run.start, run.stop - steps, steps)]
    if not spans:
        return np.empty(0)
    _, simulated = model.simulate(here, spans)
    measured = np.concatenate([here.rate[span] for span in spans])
    return np.asarray((simulated - measured)[steps :: steps + 1])


def of_split(split: Split, folder: Path) -> Record:
    """The rows of a split."""
    given = Material.of(split, folder)
    rows = {}
    methods = {**METHODS} if given.coupled is None else {**METHODS, IN_BODY: _learner_in_body}
    for name, learn in methods.items():
        rows[name] = judged(learn, given)
    found: list[Trace] = []

    def tracer(given: Material) -> Motion:
        found.append(trace_recordings(given.fitted, given.unseen, given.inertia))
        return found[0].model

    rows["incsvr trace"] = judged(tracer, given)
    return {
        "split": split.name,
        "vehicle": split.vehicle,
        "axis": split.axis,
        "about": split.about,
        "inertia": split.inertia,
        "source": split.source,
        "time_scale": given.there.scale,
        "minutes": [sum(float(np.ptp(run.time)) for run in each) / 60.0 for each in (given.fitted, given.unseen)],
        "rows": rows,
        "trace": _told(found[0]) if found else None,
    }


def _told(found: Trace) -> Record:
    """What the tracer says itself of the errors, and what it named."""
    free = {when: found.error[when]["free_run_rmse"] for when in ("before", "after")}
    return free | {
        "change": found.error["change"]["free_run_rmse"],
        "verdict": found.verdict,
        "named": [{"effect": each.effect, "parameters": each.parameters} for each in found.effects],
        "proven": found.proven,
        "beats_zero": found.beats_zero,
        "loop": found.loop,
    }


def main(words: Sequence[str] | None = None) -> int:
    parser = options("benchmarks.vehicles", __doc__)
    parser.add_argument("--data", type=Path, default=MEASURED, metavar="FOLDER", help="the measured recordings")
    parser.add_argument("--only", default="", metavar="WORD", help="splits in whose name it stands")
    args, measured = begin(parser, words, "scikit-learn", "pysindy", "sysidentpy")
    chosen = [split for split in SPLITS if args.only in split.name]
    present = [split for split in chosen if (args.data / split.vehicle).is_dir()]
    absent = sorted({split.vehicle for split in chosen} - {split.vehicle for split in present})
    if not present:
        print(f"none of {', '.join(absent) or args.only} is in {args.data}: nothing to measure", file=sys.stderr)
        return 2
    with threadpool_limits(1):
        records = in_processes(partial(of_split, folder=args.data), present, "splits", processes=1)
    document = measured | {
        "splits": records,
        "skipped": [each for each in skipped(args.data) if any(each["vehicle"] == s.vehicle for s in present)],
        "absent": absent,
    }
    publish(args.out, "vehicles", document, report(document))
    return 0


if __name__ == "__main__":
    sys.exit(main())
