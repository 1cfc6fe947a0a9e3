"""What is predicted of measured vehicles, beside other methods: every axis on recordings that were not fitted.

The splits were stated before any figure of this study was seen. A free run simulates the velocity over each unseen
recording from its first measured value, from the force (torque) and the other recorded velocities alone. *Before* and
*after* are the declared model and the traced one as `incsvr trace` reports them.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.baselines import AdaptiveIdentifier, Baseline, Data, LeastSquares, Predict, RecursiveLeastSquares
from benchmarks.peers import RUNAWAY_RATIO, Integrated, Motion, Signals, Trivial, frols, process, sindy
from benchmarks.study import HALVES, MEASURED, Record, run, table
from incsvr.errors import BadInput
from incsvr.model.efforts import Stage
from incsvr.model.scales import motion_scale
from incsvr.model.series import period
from incsvr.model.structure import Structure
from incsvr.model.windows import cut
from incsvr.numerics import Array, root_mean_square
from incsvr.plant.axes import AXES, VELOCITIES, Axis
from incsvr.signals import TORQUE, YAW_RATE
from incsvr.tracing.channels import usable_channels
from incsvr.tracing.recordings import recordings_of
from incsvr.tracing.run import Run
from service.fitting.fit import Fit
from service.fitting.trace import runs_of, trace_recordings
from service.recordings.reading import read
from service.recordings.recording import Recording, sequence
from service.recordings.samples_from_recording import samples_of, signals_for

SETTLING_RATIO = 30.0
"""Time constant of the adaptive identifier's coefficients, in those in which its copy follows, T_c (its own ratio)."""
ROV = ["run_03", "run_04", "run_05"]
CLOSED = ["run_12", "run_13", "run_14", "run_15"], ["run_07", "run_08", "run_09", "run_10", "run_11"]
INERTIAS = (
    ("dagon", "surge", 2200.0), ("dagon", "sway", 2500.0), ("dagon", "yaw", 800.0), ("blueboat", "surge", 41.8),
    ("blueboat", "yaw", 25.65), ("blueboat", "yaw", 5.7), ("kvlcc2", "yaw", 16100.0),
)  # fmt: skip
"""Vehicle, axis, declared inertia [kg], [kg m²]. The AUV's inertias are of output-error fits, the others published; 5.7
kg m² are the boat's makers' and four times too small."""
Case = tuple[str, str, float, list[str], list[str]]
"""Vehicle, axis, declared inertia, recordings that are fitted, and those that are judged on."""
SPLITS: tuple[Case, ...] = (
    *(("bluerov", "yaw", 1.125, [one for one in ROV if one != out], [out]) for out in ROV),
    ("bluerov", "yaw", 1.125, *CLOSED),
    *(
        (vehicle, axis, inertia, first, second)
        for vehicle, axis, inertia in INERTIAS for first, second in (HALVES[vehicle], HALVES[vehicle][::-1])
    ),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Material:
    """What the methods of one split are given.

    Attributes:
        inertia: declared [kg m²].
        axis: whose motion it is.
        fitted, unseen: recordings.
        there, here: the same as cells, with every channel that may drive a model; `here` is what they are judged on.
        others: the velocities that are recorded beside the axis's own.
    """

    inertia: float
    axis: Axis
    fitted: Sequence[Recording]
    unseen: Sequence[Recording]
    there: Signals
    here: Signals
    others: tuple[str, ...]

    def data(self) -> Data:
        """Samples of Eq. 5 and streams of the fitted recordings."""
        joined = sequence(self.fitted)
        samples, _ = samples_of(joined, signals_for(self.fitted, self.inertia, self.axis.fastest), None)
        return Data.of(samples, joined.streams()[YAW_RATE], joined.streams()[TORQUE])

    def curve(self, damping: Predict) -> Integrated:
        """I ṙ + d(r) = τ, as a model that simulates."""
        fastest = RUNAWAY_RATIO * float(np.max(np.abs(self.there.rate)))
        rates = np.linspace(-fastest, fastest, 8001)
        drag: Array = damping(rates)
        return Integrated(lambda rate, torque, _: (torque - np.interp(rate, rates, drag)) / self.inertia, (), fastest)


def material(case: Case) -> Material:
    vehicle, name, inertia, fitted_names, unseen_names = case
    axis = AXES[name]
    fitted, unseen = (
        [read(MEASURED / vehicle / f"{one}.csv", axis) for one in half] for half in (fitted_names, unseen_names)
    )
    runs, rest = runs_of(fitted), runs_of(unseen)
    channels, _ = usable_channels([*runs, *rest])
    channels += ["heading"] * all("heading" in each.channels for each in (*runs, *rest))
    step = period(recordings_of(runs, ()).streams, axis.rate)
    there, here = (_signals(each, channels, step) for each in (runs, rest))
    others = tuple(name for name in VELOCITIES if name in there.channels)
    return Material(inertia, axis, fitted, unseen, there, here, others)


def _signals(runs: Sequence[Run], channels: Sequence[str], step: float) -> Signals:
    """Recordings on steps of the velocity's period; an effort keeps each value."""
    found = recordings_of(runs, channels)
    driven = Structure((found.axis,), (found.axis,), channels=tuple(channels))
    windows = cut(found.streams, driven, step, np.inf)
    inside = np.concatenate([grid.first + np.arange(grid.steps) for grid in windows.grids])
    torque = windows.effort(found.axis, "hold", Stage())
    return Signals(
        step,
        np.concatenate([[0], np.cumsum([grid.steps for grid in windows.grids])]).astype(np.intp),
        windows.velocity[found.axis][inside],
        np.concatenate([torque[: grid.steps, k] for k, grid in enumerate(windows.grids)]),
        {name: 0.5 * (each[inside] + each[inside + 1]) for name, each in windows.channel.items()},
        motion_scale(found.streams, found.axis),
    )


def _baseline(method: Callable[[Material], Baseline]) -> Callable[[Material], Motion]:
    return lambda given: given.curve(method(given).fit(given.data()))


def _adaptive(given: Material) -> AdaptiveIdentifier:
    fast, scale = float(np.quantile(np.abs(given.there.rate), 0.99)), given.there.scale
    return AdaptiveIdentifier(given.inertia, fast, scale, SETTLING_RATIO * scale)


def _process(given: Material) -> Motion:
    samples, joined = given.data().samples, sequence(given.fitted)
    beside = [np.interp(samples.time, *joined.velocities[name]) for name in given.others]
    return process(np.column_stack([samples.yaw_rate, *beside]), samples.damping, given.inertia, given.others)


def _learner(given: Material) -> Motion:
    signals = signals_for(given.fitted, given.inertia, given.axis.fastest)
    model = Fit.of(given.fitted, (), signals).model
    return given.curve(lambda rate: model.predict(rate).damping)


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


def cases(asked: argparse.Namespace) -> list[Case]:
    return [case for case in SPLITS if (MEASURED / case[0]).is_dir() and asked.only in f"{case[0]}, {case[1]}"]


def examine(case: Case) -> Record:
    """The free-run error of every method on the unseen recordings [rad/s], None where it cannot be fitted."""
    given, errors, failed = material(case), dict[str, float | None](), dict[str, str]()
    with threadpool_limits(1):
        for name, learn in METHODS.items():
            try:
                errors[name] = root_mean_square(learn(given).simulate(given.here) - given.here.rate)
            except Exception as error:  # whatever a library raises for a split that it cannot fit is its result
                errors[name], failed[name] = None, str(error)
        record: Record = {"split": f"{case[0]}, {case[1]}, {case[2]:g}: {', '.join(case[3])} → {', '.join(case[4])}",
                          "errors": errors, "failed": failed, "trace": None}  # fmt: skip
        try:
            found = trace_recordings(given.fitted, given.unseen, given.inertia)
        except BadInput as error:
            return record | {"failed": failed | {"incsvr trace": str(error)}}
    free = {when: found.error[when]["free_run_rmse"] for when in ("before", "after", "change")}
    named = [each.effect for each in found.effects]
    return record | {"trace": {**free, "named": named, "verdict": found.verdict, "proven": found.proven}}


def report(results: Sequence[Record]) -> Iterator[str]:
    rows, beaten = [], 0
    for record in results:
        errors, traced = record["errors"], record["trace"]
        ours = [errors["incsvr fit"], *([traced["before"], traced["after"]] if traced else [])]
        least = min((error for error in ours if error is not None), default=np.inf)
        beaten += any(error is not None and error < least for name, error in errors.items() if name != "incsvr fit")
        cells = ["–" if error is None else f"**{error:.3g}**" if error < least else f"{error:.3g}"
                 for error in errors.values()]  # fmt: skip
        told = ["–"] * 4
        if traced:
            change = traced["change"]
            told = [f"{traced['before']:.3g} → {traced['after']:.3g}", f"{change['low']:+.2g} to {change['high']:+.2g}",
                    ", ".join(traced["named"]) or f"nothing ({traced['verdict']})",
                    "yes" if traced["proven"] else "no"]  # fmt: skip
        rows.append([record["split"], *cells, *told])
    yield (
        "RMS error of the free run in rad/s (yaw) or m/s (surge, sway); a split is vehicle, axis, declared inertia: "
        f"fitted → unseen. In {beaten} of {len(results)} splits another method errs less than all of ours (bold)."
    )
    yield table(["split", *METHODS, "incsvr trace", "change, 95 %", "named", "proven"], rows)
    yield "\n".join(f"- {record['split']}: {name} failed: {why}" for record in results
                    for name, why in record["failed"].items())  # fmt: skip


def main(words: Sequence[str] | None = None) -> None:
    run("vehicles", __doc__, cases, examine, report, words, ("scikit-learn", "pysindy", "sysidentpy"),
        only=("", "part of `vehicle, axis`"))  # fmt: skip


if __name__ == "__main__":
    main()
