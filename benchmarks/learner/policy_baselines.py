"""The baselines that the paper cites, on the streams of the study of the policies: fitted to what came last.

None of them forgets by itself but recursive least squares and the adaptive identifier, so that the others are fitted to
the last LAST samples. The adaptive identifier needs the streams of yaw rate and torque, which missions alone have.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.learner.policy_missions import MISSIONS, played
from benchmarks.learner.policy_scenarios import RATES, SCENARIOS
from benchmarks.paper.baselines import LeastSquaresSVR, NeuralNetwork
from incsvr.learning.baselines import (
    AdaptiveIdentifier,
    Baseline,
    Data,
    LeastSquares,
    RecursiveLeastSquares,
    TotalLeastSquares,
)
from incsvr.numerics import root_mean_square
from incsvr.signals import TORQUE, YAW_RATE, synchronise
from incsvr.signals.samples import Samples
from service.recordings.recording_csv import RATE_LIMIT
from service.recordings.samples_from_recording import signals_for

Record = dict[str, Any]
LAST = 500
"""Samples: ten of the paper's batches."""
FITTED: Mapping[str, Baseline] = {
    "least squares": LeastSquares(),
    "total least squares": TotalLeastSquares(),
    "recursive least squares": RecursiveLeastSquares(),
    "small network": NeuralNetwork(),
    "least-squares SVR": LeastSquaresSVR(),
}
ADAPTIVE = "adaptive identifier"
NAMES = (*FITTED, ADAPTIVE)


@dataclass(frozen=True, slots=True)
class Names:
    """Which scenarios and missions are tried."""

    scenarios: tuple[str, ...]
    missions: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.scenarios) + len(self.missions)

    @staticmethod
    def of(only: Sequence[str] | None) -> Names:
        """Those of a list, or all without one."""
        return Names(
            tuple(name for name in SCENARIOS if only is None or name in only),
            tuple(kind for kind in MISSIONS if only is None or kind in only),
        )


def table(seeds: Sequence[int], names: Names, advance: Callable[[], None]) -> list[Record]:
    """Each baseline's figures by scenario and mission: name, and under each baseline a value for each seed."""
    cases: list[tuple[str, Callable[[int], dict[str, float]]]] = []
    cases += [(name, lambda seed, name=name: at_the_end(name, seed)) for name in names.scenarios]  # type: ignore[misc]
    cases += [
        (f"mission: {kind}", lambda seed, kind=kind: after_a_mission(kind, seed))  # type: ignore[misc]
        for kind in names.missions
    ]
    records = []
    # On matrices as small as these the threads of the linear algebra only wait for each other.
    with threadpool_limits(1):
        for name, case in cases:
            found = []
            for seed in seeds:
                found.append(case(seed))
                advance()
            records.append({"name": name, "values": {each: [one[each] for one in found] for each in found[0]}})
    return records


def at_the_end(name: str, seed: int) -> dict[str, float]:
    """RMS to the truth [N m] of each baseline after a whole scenario."""
    case = SCENARIOS[name]
    samples = case.draw(seed)
    data = _data(samples)
    truth = case.truth(case.samples)
    return {each: root_mean_square(baseline.fit(data).predict(RATES) - truth) for each, baseline in FITTED.items()}


def after_a_mission(kind: str, seed: int) -> dict[str, float]:
    """RMS to the truth at the driven rates, over the water's deviation, of each baseline after a mission."""
    outcome = played(kind, seed)
    recording = outcome.recording
    signals = signals_for([recording], outcome.inertia, RATE_LIMIT)
    samples, _ = synchronise(signals, recording.streams())
    rates = outcome.driven_rates
    truth = outcome.damping(rates)
    found = {each: baseline.fit(_data(samples)).predict(rates) for each, baseline in FITTED.items()}
    streams = recording.streams()
    scale = float(np.quantile(np.abs(samples.yaw_rate), 0.99))
    identifier = AdaptiveIdentifier(inertia=outcome.inertia, rate_scale=scale)
    found[ADAPTIVE] = identifier.fit(Data.of(samples, streams[YAW_RATE], streams[TORQUE])).predict(rates)
    return {each: root_mean_square(served - truth) / outcome.water_rms for each, served in found.items()}


def _data(samples: Samples) -> Data:
    last = samples.take(slice(-LAST, None))
    nothing = np.empty(0)
    return Data(last, nothing, nothing, nothing)
