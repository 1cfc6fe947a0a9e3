"""The figures of one case and seed under both policies, and of the baselines that the paper cites beside them.

No baseline forgets by itself but recursive least squares and the adaptive identifier, so that the others are fitted to
the last FITTED_SAMPLES samples. The adaptive identifier needs the streams of yaw rate and torque, which missions alone
have.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.learner.policies import GAMMA, POLICIES, Policy, batches, scaled
from benchmarks.learner.policy_scenarios import RATES, SCENARIOS
from benchmarks.paper.baselines import (
    AdaptiveIdentifier,
    Baseline,
    Data,
    LeastSquares,
    RecursiveLeastSquares,
    TotalLeastSquares,
)
from benchmarks.paper.library_baselines import LeastSquaresSVR, NeuralNetwork
from benchmarks.study import Record
from incsvr.learning.dual import solve
from incsvr.learning.kernel import rbf
from incsvr.learning.learner import Settings, start, step
from incsvr.numerics import root_mean_square
from incsvr.signals import TORQUE, YAW_RATE, synchronise
from incsvr.signals.samples import Samples
from service.recordings.recording_csv import RATE_LIMIT
from service.recordings.samples_from_recording import Errors, learn, signals_for
from simulator import leng
from simulator.missions import Mission, Outcome, play

EXPERIMENT = "experiment"
MISSIONS = ("survey", "waypoints", "zigzag", "circles", "day")
"""Ordinary missions, of the vehicle "auv", on which both are tried."""
CASES = (EXPERIMENT, *SCENARIOS, *MISSIONS)
SETTLED_RATIO = 1.03
"""An error has settled from the batch on after which it stays below this times its final value."""
SOON_BATCHES = 4
"""Batches in which a policy should have settled after a change."""
FITTED_SAMPLES = 500
"""Samples: ten of the paper's batches."""
FITTED: Mapping[str, Baseline] = {
    "least squares": LeastSquares(),
    "total least squares": TotalLeastSquares(),
    "recursive least squares": RecursiveLeastSquares(),
    "small network": NeuralNetwork(),
    "least-squares SVR": LeastSquaresSVR(),
}
ADAPTIVE = "adaptive identifier"
Figures = dict[tuple[str, str], float]
"""What happens and what is measured, with its unit → the figure."""


def examine(work: tuple[str, int]) -> Record:
    """Every figure of a case and a seed by policy, and the baselines' errors by name."""
    name, seed = work
    # On matrices as small as these the threads of the linear algebra only wait for each other.
    with threadpool_limits(1):
        if name == EXPERIMENT:
            return _record(name, {policy: experiment(seed, policy) for policy in POLICIES}, {})
        if name in SCENARIOS:
            return _record(name, {policy: scenario(name, seed, policy) for policy in POLICIES}, at_the_end(name, seed))
        outcome = play(Mission(name, "auv", seed))
        figures = {policy: mission(outcome, policy) for policy in POLICIES}
        return _record(f"mission: {name}", figures, after_a_mission(outcome))


def _record(name: str, by_policy: Mapping[Policy, Figures], baselines: dict[str, float]) -> Record:
    figures = [
        {"name": key[0], "figure": key[1]} | {policy: by_policy[policy][key] for policy in POLICIES}
        for key in by_policy["paper"]
    ]
    return {"case": name, "figures": figures, "baselines": baselines}


def experiment(seed: int, policy: Policy) -> Figures:
    """The Leng experiment: the learner over T1 and T2, against offline SVRs with the same hyper-parameters."""
    data = leng.experiment(seed)
    settings = Settings(policy=policy, gamma=GAMMA[policy])
    state, curves, largest = start(settings), [], 0
    for training, validation in ((data.T1, data.V1), (data.T2, data.V2)):
        offline = solve(
            training.yaw_rate, training.damping, gamma=GAMMA["paper"], C=settings.C, epsilon=settings.epsilon
        )
        curve_of_all = rbf(validation.yaw_rate, training.yaw_rate, GAMMA["paper"]) @ offline.weight
        reference = float(np.abs(curve_of_all - validation.damping).mean())
        curve = []
        for batch in batches(training, settings.batch):
            state, _ = step(settings, state, batch)
            largest = max(largest, state.model.weight.size)
            curve.append(Errors.of(state.model, validation).mae / reference)
        curves.append(np.array(curve))
    first, second = curves
    unsettled = np.flatnonzero(second > SETTLED_RATIO * second[-1])
    return {
        ("T1 → V1", "final MAE over the offline SVR's"): float(first[-1]),
        ("T2 → V2", "final MAE over the offline SVR's"): float(second[-1]),
        ("T2 → V2", f"mean of the first {SOON_BATCHES} batches' MAE over the offline SVR's"): float(
            second[:SOON_BATCHES].mean()
        ),
        ("T2 → V2", "batches until within 3 % of the final MAE for good"): float(unsettled.max(initial=-1) + 2),
        ("T1, T2", "most vectors served"): float(largest),
    }


def scenario(name: str, seed: int, policy: Policy) -> Figures:
    """One scenario: RMS of the served curve to the true one [N m]."""
    case = SCENARIOS[name]
    settings = Settings(policy=policy, gamma=GAMMA[policy])
    errors = []
    for number, iteration in enumerate(learn(case.draw(seed), settings), 1):
        if number * settings.batch > case.event:
            errors.append(
                root_mean_square(iteration.model.predict(RATES).damping - case.truth(number * settings.batch))
            )
    figures = {
        (name, "RMS to the truth, mean of all batches since [N m]"): float(np.mean(errors)),
        (name, "RMS to the truth, mean of the last four batches [N m]"): float(np.mean(errors[-4:])),
    }
    if name not in ("drift", "nothing", "nothing, correlated", "low speed", "hull at low speed", "wrong inertia"):
        figures[name, f"RMS to the truth, mean of the first {SOON_BATCHES} batches since [N m]"] = float(
            np.mean(errors[:SOON_BATCHES])
        )
    return figures


def mission(outcome: Outcome, policy: Policy) -> Figures:
    """An ordinary mission with nothing hidden: RMS of the served curve to the true one over the driven rates.

    Where nothing is learned nothing is served, and the error is all of the damping.
    """
    samples = _samples(outcome)
    model = list(learn(samples, scaled(samples, policy)))[-1].model
    rates = outcome.driven_rates
    served = model.predict(rates).damping if model.is_trained else np.zeros(rates.size)
    figure = "RMS to the truth at the driven rates, over the water's deviation"
    return {
        (f"mission: {outcome.mission.kind}", figure): root_mean_square(served - outcome.damping(rates))
        / outcome.water_rms
    }


def at_the_end(name: str, seed: int) -> dict[str, float]:
    """RMS to the truth [N m] of each baseline after a whole scenario."""
    case = SCENARIOS[name]
    data, truth = _last(case.draw(seed)), case.truth(case.samples)
    return {each: root_mean_square(baseline.fit(data).predict(RATES) - truth) for each, baseline in FITTED.items()}


def after_a_mission(outcome: Outcome) -> dict[str, float]:
    """RMS to the truth at the driven rates, over the water's deviation, of each baseline after a mission."""
    samples, streams, rates = _samples(outcome), outcome.recording.streams(), outcome.driven_rates
    served = {each: baseline.fit(_last(samples)).predict(rates) for each, baseline in FITTED.items()}
    scale = float(np.quantile(np.abs(samples.yaw_rate), 0.99))
    identifier = AdaptiveIdentifier(inertia=outcome.inertia, rate_scale=scale)
    served[ADAPTIVE] = identifier.fit(Data.of(samples, streams[YAW_RATE], streams[TORQUE])).predict(rates)
    return {
        each: root_mean_square(curve - outcome.damping(rates)) / outcome.water_rms for each, curve in served.items()
    }


def _samples(outcome: Outcome) -> Samples:
    signals = signals_for([outcome.recording], outcome.inertia, RATE_LIMIT)
    return synchronise(signals, outcome.recording.streams())[0]


def _last(samples: Samples) -> Data:
    nothing = np.empty(0)
    return Data(samples.take(slice(-FITTED_SAMPLES, None)), nothing, nothing, nothing)
