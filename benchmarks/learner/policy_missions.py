"""Ordinary missions for the study of the policies: what is served beside the truth."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from benchmarks.learner.policies import Policy, scaled
from incsvr.numerics import root_mean_square
from incsvr.signals import synchronise
from service.recordings.recording_csv import RATE_LIMIT
from service.recordings.samples_from_recording import learn, signals_for
from simulator.missions import Mission, Outcome, play

MISSIONS = ("survey", "waypoints", "zigzag", "circles", "day")
"""Ordinary missions, of the vehicle "auv", on which both are tried."""


@lru_cache(maxsize=1)
def played(kind: str, seed: int) -> Outcome:
    """The mission, kept for whoever asks next."""
    return play(Mission(kind, "auv", seed))


def mission(kind: str, seed: int, policy: Policy) -> dict[tuple[str, str], float]:
    """An ordinary mission with nothing hidden: RMS of the served curve to the true one over the driven rates.

    Where nothing is learned nothing is served, and the error is all of the damping.
    """
    outcome = played(kind, seed)
    signals = signals_for([outcome.recording], outcome.inertia, RATE_LIMIT)
    samples = synchronise(signals, outcome.recording.streams())[0]
    model = list(learn(samples, scaled(samples, policy)))[-1].model
    rates = outcome.driven_rates
    served = model.predict(rates).damping if model.is_trained else np.zeros(rates.size)
    error = root_mean_square(served - outcome.damping(rates))
    return {
        (f"mission: {kind}", "RMS to the truth at the driven rates, over the water's deviation"): error
        / outcome.water_rms
    }
