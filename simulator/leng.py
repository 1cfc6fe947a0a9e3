"""The AUV Leng (3.75 m, 76 kg dry) and its experiment (Section IV) as data.

The vehicle turns about its vertical axis alone, driven by two lateral thrusters whose rotor speed follows a sinusoid up
to the maximum thrust, slow enough to reach the maximum rate. First without (V1, T1), then with a hull around the rear
thruster (V2, T2), which raises the damping by about a tenth; the validation runs are collected first. Yaw rate and
torque are recorded by clocks of their own and become damping samples through incsvr.signals like everything else.

What the equation of motion does not hold moves the vehicle: the eddies that it sheds, and thrust that wavers about what
its rotors' speeds make it. Both last for a while, and no sensor sees them. The gyro is as good as the paper's and adds
a three-hundredth of them.

WATER, WAVERING and HULL are set so that the offline baselines meet their rows of Table I (within 2.2 %, mean of seeds
3000 to 3099). Nothing is set on the IncSVR rows: those are results. The paper tells neither the arms of the thrusters
nor the colour of its noise; here the residual of one sample and the next correlate by 0.20.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import exp, pi, sqrt
from typing import TypeVar

import numpy as np

from incsvr.numerics import Array
from incsvr.plant import Thruster, thruster_torque
from incsvr.signals import TORQUE, YAW_RATE, SignalSettings, synchronise
from incsvr.signals.samples import Samples
from service.recordings.recording import Recording

INERTIA = 350.0
"""I, dry and added mass [kg m²]."""
MAX_RATE = 0.25
"""The vehicle's largest yaw rate [rad/s]."""
MAX_SPEED = 141.4
"""Largest rotor speed [rad/s]: 40 N of thrust at rest; two such thrusters on arms of 1.25 m make 100 N m."""
BOW = Thruster(lever=1.25, thrust=2.0e-3, inflow=-0.035)
STERN = Thruster(lever=-1.25, thrust=2.0e-3, inflow=-0.035)
THRUSTERS = (BOW, STERN)
SIGNALS = SignalSettings(inertia=INERTIA, sample_period=0.6, smoothing=0.12, lateness=0.2, gap=0.2, rate_limit=1.0)

HULL = 0.12
"""What the hull adds to the damping, as a part of it."""
WATER, WATER_MEMORY = 3.3, 0.45
"""The water's own moment: its standard deviation [N m] and how long it lasts [s], as long as an eddy of a body 0.2 m
thick takes to turn by a radian (Strouhal number 0.2) at the mean speed of its hull, 0.35 m/s."""
WAVERING, WAVERING_MEMORY = {False: (0.094, 0.094), True: (0.094, 0.14)}, 0.15
"""By how much the thrusts of bow and stern waver, as a part of them, without and with the hull, in which the stern
thruster then works; and for how long [s]: a jet of 1.5 m/s crosses its rotor in a tenth of a second."""
ANGLE_RANDOM_WALK = 3.5e-6
"""The KVH-1750's, 0.012 °/√h [rad/√s]."""
GYRO_PERIOD, ROTOR_PERIOD = 0.02, 0.04
"""Sampling of the gyro and of the rotor speeds [s]."""
ROTOR_NOISE = 0.5
"""Standard deviation of a measured rotor speed [rad/s]."""
_STEP = 0.02

Quantity = TypeVar("Quantity", float, Array)


@dataclass(frozen=True, slots=True)
class Run:
    """How one of the four runs is made.

    Attributes:
        duration: [s].
        period: of the sinusoidal command [s].
        hull: whether the hull is mounted.
    """

    duration: float
    period: float
    hull: bool


RUNS: Mapping[str, Run] = {
    "V1": Run(300.0, 61.0, hull=False),
    "T1": Run(421.0, 67.0, hull=False),
    "V2": Run(300.0, 61.0, hull=True),
    "T2": Run(331.0, 67.0, hull=True),
}
"""In the order in which they were collected; T1 gives 700 samples, T2 550."""


@dataclass(frozen=True, slots=True)
class Experiment:
    """Damping samples of the four runs: two to train on, two to validate with."""

    T1: Samples
    V1: Samples
    T2: Samples
    V2: Samples


def damping(rate: Quantity, hull: bool = False) -> Quantity:
    """The vehicle's true d(r) [N m] at yaw rates r [rad/s], one number or (n,).

    Linear and quadratic drag (N_r r and N_rr r|r|), the quadratic part stronger where the flow is slow, as drag
    coefficients are: no polynomial fits it exactly.
    """
    quadratic = 1050.0 * abs(rate) * (1.0 + 0.4 / (1.0 + (rate / 0.1) ** 2))
    moment: Quantity = (1.0 + HULL * hull) * rate * (100.0 + quadratic)
    return moment


def experiment(seed: int) -> Experiment:
    """The samples of one repetition; the seed draws the sensors' noise and the phase at which the command begins."""
    return Experiment(**{name: samples(recording(name, seed)) for name in RUNS})


def samples(run: Recording) -> Samples:
    """The damping samples of a recording, through the same code that the learner runs on."""
    return synchronise(SIGNALS, run.streams())[0]


def recording(name: str, seed: int) -> Recording:
    """One of the runs V1, T1, V2, T2 as the vehicle would record it: yaw rate [rad/s] and torque [N m].

    Args:
        name: a key of RUNS.
        seed: the same seed and name give the same recording.
    """
    run = RUNS[name]
    rng = np.random.default_rng([seed, *name.encode()])
    time, rate, rotor = _motion(run, rng)
    return sensed(name, time, rate, rotor, rng, run.duration)


def sensed(
    name: str, time: Array, rate: Array, rotor: Sequence[Array], rng: np.random.Generator, duration: float = 0.0
) -> Recording:
    """A motion as gyro and rotors' sensors record it; the torque is that of rotors that are sound.

    Args:
        name: of the recording.
        time, rate: (n,) [s], [rad/s].
        rotor: speeds of both (n,) [rad/s].
        rng: draws clocks and noise.
        duration: until when is recorded [s]; 0 for the last time.
    """
    duration = duration or float(time[-1])
    gyro = stamps(duration, GYRO_PERIOD, rng)
    yaw_rate = np.interp(gyro, time, rate) + rng.normal(0.0, ANGLE_RANDOM_WALK / np.sqrt(GYRO_PERIOD), gyro.size)
    spin = stamps(duration, ROTOR_PERIOD, rng)
    speeds = [np.interp(spin, time, speed) + rng.normal(0.0, ROTOR_NOISE, spin.size) for speed in rotor]
    turn = np.interp(spin, time, rate)
    torque = thruster_torque(THRUSTERS, tuple(speeds), tuple(thruster.lever * turn for thruster in THRUSTERS))
    return Recording(name, {YAW_RATE: (gyro, yaw_rate.round(6)), TORQUE: (spin, torque.round(4))})


def _motion(run: Run, rng: np.random.Generator) -> tuple[Array, Array, tuple[Array, Array]]:
    """The vehicle's motion from rest, integrated by Runge–Kutta: time, yaw rate and the speeds of both rotors."""
    phase = rng.uniform(0.0, 2.0 * pi)
    half: Array = np.arange(2 * round(run.duration / _STEP) + 1, dtype=np.float64) * (_STEP / 2.0)
    speed: Array = MAX_SPEED * np.sin(2.0 * pi * half / run.period + phase)
    rotor = (speed, -speed)
    # The thrusters' moment is linear in the yaw rate; both parts are needed at the whole and at the half steps.
    at_rest, rising = WATER * lasting(WATER_MEMORY, 0.5 * _STEP, half.size, rng), np.zeros(half.size)
    for thruster, spin, share in zip(THRUSTERS, rotor, WAVERING[run.hull], strict=True):
        part = 1.0 + share * lasting(WAVERING_MEMORY, 0.5 * _STEP, half.size, rng)
        moment = thruster.moment(spin, np.zeros(half.size))
        at_rest = at_rest + part * moment
        rising = rising + part * (thruster.moment(spin, np.full(half.size, thruster.lever)) - moment)
    still: list[float] = at_rest.tolist()
    moving: list[float] = rising.tolist()

    def acceleration(k: int, r: float) -> float:
        return (still[k] + moving[k] * r - damping(r, run.hull)) / INERTIA

    rates = [0.0]
    r = 0.0
    for k in range(0, half.size - 1, 2):
        k1 = acceleration(k, r)
        k2 = acceleration(k + 1, r + 0.5 * _STEP * k1)
        k3 = acceleration(k + 1, r + 0.5 * _STEP * k2)
        k4 = acceleration(k + 2, r + _STEP * k3)
        r += _STEP / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        rates.append(r)
    return half[::2], np.array(rates), (speed[::2], -speed[::2])


def lasting(memory: float, step: float, size: int, rng: np.random.Generator) -> Array:
    """An Ornstein–Uhlenbeck process of deviation one, (size,) values `step` apart, that lasts `memory` [s]."""
    kept = exp(-step / memory)
    values = [float(rng.standard_normal())]
    for kick in (sqrt(1.0 - kept**2) * rng.standard_normal(size)).tolist()[:-1]:
        values.append(kept * values[-1] + kick)
    return np.array(values)


def stamps(duration: float, period: float, rng: np.random.Generator) -> Array:
    """Stamps of a sensor's own clock [s], to the microsecond: any phase, and some jitter."""
    stamps = np.arange(rng.uniform(0.0, period), duration, period)
    return np.asarray((stamps + rng.uniform(0.0, 0.1 * period, stamps.size)).round(6))
