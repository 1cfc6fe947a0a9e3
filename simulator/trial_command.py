"""What is asked of a trial vehicle's thrusters: six kinds of excitation, open loop and closed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from simulator.noise import lasting_noise
from simulator.trial_effects import Scale
from simulator.trial_effects.physics import Array

EXCITATIONS = ("sine", "multisine", "telegraph", "steps", "chirp", "closed_loop")


@dataclass(frozen=True, slots=True)
class Command:
    """The commanded moment: a table, or a rate controller (PI with a limit, no wind-up) that follows a table.

    Attributes:
        table: one value a tick, N m in open loop, rad/s in closed loop.
        proportional, integral: the controller's gains [N m s/rad], [N m/rad]; zero in open loop.
        limit: the largest moment that may be asked [N m].
        hold: integration steps for which a command stands; 0 for a table that runs on continuously.
        step: resolution of the commands [N m], 0 for none.
    """

    table: list[float]
    proportional: float = 0.0
    integral: float = 0.0
    limit: float = math.inf
    hold: int = 0
    step: float = 0.0

    def at(self, tick: int, rate: float, integrated: float) -> tuple[float, float]:
        """The moment [N m] when the gyro shows this rate, and the slope of the integrated error [rad/s]."""
        if not self.proportional:
            return self._rounded(self.table[tick]), 0.0
        error = self.table[tick] - rate
        asked = self.proportional * error + self.integral * integrated
        if abs(asked) > self.limit:
            return self._rounded(math.copysign(self.limit, asked)), 0.0
        return self._rounded(asked), error

    def _rounded(self, moment: float) -> float:
        return round(moment / self.step) * self.step if self.step else moment


def command(kind: str, scale: Scale, time: Array, random: np.random.Generator, hold: int = 0) -> Command:
    """An excitation of the given kind.

    Args:
        kind: one of EXCITATIONS.
        scale: the vehicle's; times are counted in its I r/τ.
        time: (ticks,) [s].
        random: draws amplitudes, periods and phases.
        hold: integration steps for which a command stands; a controller needs one.

    Raises:
        KeyError: no such kind.
    """
    if kind == "closed_loop":
        return replace(_closed_loop(scale, time, random), hold=hold)
    shape = {"sine": _sine, "multisine": _multisine, "telegraph": _telegraph, "steps": _steps, "chirp": _chirp}[kind]
    return Command((scale.torque * shape(time / scale.time, random)).tolist(), hold=hold)


def _sine(time: Array, random: np.random.Generator) -> Array:
    """One sine, near full torque."""
    period, phase = random.uniform(15.0, 40.0), random.uniform(0, 2 * math.pi)
    return np.asarray(random.uniform(0.9, 1.0) * np.sin(2 * math.pi * time / period + phase))


def _multisine(time: Array, random: np.random.Generator) -> Array:
    """Five to nine sines over a decade of periods, peak near full torque."""
    count = int(random.integers(5, 10))
    periods = np.geomspace(6.0, 60.0, count) * random.uniform(0.9, 1.1, count)
    phases = random.uniform(0, 2 * math.pi, count)
    weight = np.sqrt(periods)
    total = sum(k * np.sin(2 * math.pi * time / p + f) for k, p, f in zip(weight, periods, phases, strict=True))
    return np.asarray(random.uniform(0.9, 1.0) * total / np.max(np.abs(total)))


def _hold(time: Array, mean: float, random: np.random.Generator) -> NDArray[np.intp]:
    """Which hold each instant lies in; holds last at least a third of their mean."""
    count = int(2 * time[-1] / mean) + 10
    edges = np.cumsum(mean * (1 / 3 + 2 / 3 * random.exponential(size=count)))
    return np.searchsorted(edges, time, side="right")


def _telegraph(time: Array, random: np.random.Generator) -> Array:
    """Held for random times at one of a few levels of either sign."""
    hold = _hold(time, random.uniform(4.0, 10.0), random)
    levels = np.array([-1.0, -0.55, 0.55, 1.0]) * random.uniform(0.9, 1.0)
    return np.asarray(random.choice(levels, size=int(hold[-1]) + 1)[hold])


def _steps(time: Array, random: np.random.Generator) -> Array:
    """A staircase through random levels, each held until the rate has settled."""
    hold = _hold(time, random.uniform(12.0, 25.0), random)
    return np.asarray(random.uniform(-1.0, 1.0, size=int(hold[-1]) + 1)[hold])


def _chirp(time: Array, random: np.random.Generator) -> Array:
    """A sine whose period shrinks from long to short, again and again."""
    sweep = random.uniform(150.0, 260.0)
    slow, fast = random.uniform(35.0, 60.0), random.uniform(5.0, 8.0)
    ratio = slow / fast
    part = (time % sweep) / sweep
    # The phase of an exponential chirp is the integral of its frequency; whole sweeps add up so that no jump occurs.
    within = sweep / slow * (ratio**part - 1.0) / math.log(ratio)
    whole = np.floor(time / sweep) * sweep / slow * (ratio - 1.0) / math.log(ratio)
    return np.asarray(random.uniform(0.9, 1.0) * np.sin(2 * math.pi * (within + whole)))


def _closed_loop(scale: Scale, time: Array, random: np.random.Generator) -> Command:
    """A rate controller that follows steps rounded off by a first-order filter, or a multisine."""
    scaled = time / scale.time
    if random.random() < 0.5:
        wanted = 0.98 * _multisine(scaled, random)
    else:
        levels = 0.98 * _steps(scaled, random)
        tick = float(scaled[1] - scaled[0])
        keep = math.exp(-tick / random.uniform(1.0, 3.0))
        wanted = lasting_noise(0.0, keep, (1 - keep) * levels)
    proportional = random.uniform(2.0, 4.0) * scale.torque / scale.rate
    integral = proportional / (random.uniform(3.0, 6.0) * scale.time)
    return Command((scale.rate * wanted).tolist(), proportional, integral, scale.torque)
