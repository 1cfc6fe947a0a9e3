"""The trials of the confusion matrix. A group and a seed name a case, whatever else is tried beside it."""

from __future__ import annotations

import numpy as np

from simulator.trial import Trial
from simulator.trial_command import EXCITATIONS
from simulator.trial_effects import EFFECTS
from simulator.trial_vehicle import SCALES

GROUPS = {
    "one": "one effect of realistic size",
    "half": "one effect at half the size",
    "two": "two effects at once",
    "quiet": "nothing hidden",
}
KINDS = (*EFFECTS, "coupling", "coupling", "modulation", "modulation")
COUPLING = ("sway", "surge", "roll_rate", "winch_load", "ballast_flow", "arm_angle")
MODULATION = ("voltage", "depth", "temperature", "winch_load")
AUTOCORRELATIONS = (0.0, 0.5, 0.9, 0.98)
"""Autocorrelations of the residual in quiet trials; a trial with an effect draws one of the first three."""
FAMILIES = (
    {"torque_lag", "torque_delay"},
    {"drag_drift", "drag_step"},
    {"bias_torque", "bias_drift"},
)
"""Two effects of one family are one effect in two names, so they are not hidden together."""


def case(group: str, index: int, first_seed: int, duration: float = 720.0) -> Trial:
    """The `index`-th trial of a group; consecutive indices go through effects, then excitations, then vehicles.

    Raises:
        KeyError: no such group.
    """
    seed = first_seed + index
    vehicles = tuple(SCALES)
    random = np.random.default_rng([seed, 7])
    if group == "quiet":
        step = index // len(AUTOCORRELATIONS)
        return Trial(
            seed=seed,
            vehicle=vehicles[(step + step // len(EXCITATIONS)) % 2],
            excitation=EXCITATIONS[step % len(EXCITATIONS)],
            autocorrelation=AUTOCORRELATIONS[index % len(AUTOCORRELATIONS)],
            duration=duration,
        )
    autocorrelation = float(random.choice(AUTOCORRELATIONS[:3]))
    if group == "two":
        effects: tuple[str, ...] = _pair(random)
        excitation, vehicle = EXCITATIONS[index % len(EXCITATIONS)], vehicles[index // len(EXCITATIONS) % 2]
    else:
        step = index // len(KINDS)
        effects = (_whole_name(KINDS[index % len(KINDS)], random),)
        excitation = EXCITATIONS[step % len(EXCITATIONS)]
        vehicle = vehicles[(index + step + step // len(EXCITATIONS)) % 2]
    size = {"one": 1.0, "two": 1.0, "half": 0.5}[group]
    return Trial(seed, effects, size, vehicle, excitation, autocorrelation, duration)


def _whole_name(kind: str, random: np.random.Generator) -> str:
    channels = {"coupling": COUPLING, "modulation": MODULATION}.get(kind)
    return kind if channels is None else f"{kind}:{random.choice(channels)}"


def _pair(random: np.random.Generator) -> tuple[str, str]:
    while True:
        first, second = (_whole_name(str(kind), random) for kind in random.choice(KINDS, 2, replace=False))
        channels = {name.partition(":")[2] for name in (first, second)} - {""}
        related = any(first in family and second in family for family in FAMILIES)
        if first != second and not related and (":" not in first or ":" not in second or len(channels) == 2):
            return first, second
