"""Sound recordings of all kinds: what the checks put aside of them, and why.

Ten minutes each of the Leng, of a light ROV and of a small AUV, at 5 to 50 Hz, with a gyro, a measured torque and water
that are as they always were. The learner is scaled to each recording as `incsvr fit` does it. Every batch that is put
aside is a false one, and so is every finding.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from benchmarks.study import Record, grouped, run, seeds, table
from incsvr.checks import Decision, Vehicle, Verdict
from incsvr.learning import checked_learner
from incsvr.numerics import Array
from service.recordings.reading import RATE_LIMIT
from service.recordings.recording import Recording
from service.recordings.samples_from_recording import learner_for, samples_of, signals_for
from simulator import leng

LASTS_S, STEP_S = 600.0, 0.02
TORQUE_SHARES = (0.3, 0.5, 0.7, 0.9)
"""Parts of the largest torque that steps have."""


@dataclass(frozen=True, slots=True)
class Turning:
    """A vehicle that turns: inertia [kg m²], largest torque [N m] and yaw rate [rad/s], and its damping d(r) [N m]."""

    inertia: float
    torque: float
    rate: float
    damping: Callable[[float], float]


VEHICLES = {
    "leng": Turning(leng.INERTIA, 100.0, 0.25, leng.damping),
    "rov": Turning(0.6, 1.5, 1.0, lambda r: 0.4 * r + 0.9 * r * abs(r)),
    "small": Turning(12.0, 12.0, 0.8, lambda r: 4.0 * r + 12.0 * r * abs(r)),
}


@dataclass(frozen=True, slots=True)
class Kind:
    """How a recording is made.

    Attributes:
        manoeuvre: "steps", "sine", "rest", "relay", "heading" or "station".
        hold_s: how long a command holds, shortest and longest [s].
        rests: part of the commands that are none.
        noise, water, swell: the gyro's noise in largest rates; the water's moment and a swell's in largest torques.
        hertz: of the commands, where they are measured seldom.
        torque_noise: of the torque in largest torques.
    """

    manoeuvre: str = "steps"
    hold_s: tuple[float, float] = (4.0, 10.0)
    rests: float = 0.0
    noise: float = 0.01
    water: float = 0.02
    swell: float = 0.0
    hertz: float = 25.0
    torque_noise: float = 0.0


KINDS = {
    "steps of 4–10 s": Kind(),
    "steps of 3–8 s without noise": Kind(hold_s=(3.0, 8.0), noise=0.0, water=0.0),
    "held for 6–20 s without noise": Kind(hold_s=(6.0, 20.0), noise=0.0, water=0.0),
    "limit cycle": Kind("relay"),
    "disarmed": Kind("rest", water=0.05),
    "steps with rests": Kind(rests=0.5),
    "steps in a swell": Kind(swell=0.1),
    "rest": Kind("rest", water=0.0),
    "slow commands, 1–2 Hz": Kind(hertz=1.5),
    "sine": Kind("sine"),
    "station": Kind("station", swell=0.05),
    "heading held": Kind("heading", swell=0.05),
    "steps at 5 Hz": Kind(hertz=5.0),
    "steps at 10 Hz, noisy torque": Kind(hertz=10.0, torque_noise=0.02),
}
Case = tuple[str, str, int]
"""Kind, vehicle, seed."""


def recording_of(case: Case) -> Recording:
    """The recording of a case."""
    name, called, seed = case
    kind, vehicle = KINDS[name], VEHICLES[called]
    rng = np.random.default_rng([seed, *name.encode(), *called.encode()])
    time, rate, torque = motion(kind, vehicle, rng)
    gyro_period = 0.2 if kind.hertz == 5.0 else 0.1 if kind.hertz == 10.0 else STEP_S
    gyro = leng.stamps(LASTS_S, gyro_period, rng)
    commands = leng.stamps(LASTS_S, 1.0 / kind.hertz, rng)
    measured = np.interp(gyro, time, rate) + rng.normal(0.0, kind.noise * vehicle.rate, gyro.size)
    at = np.clip((commands / STEP_S).astype(int), 0, torque.size - 1)
    commanded = torque[at] + rng.normal(0.0, kind.torque_noise * vehicle.torque, at.size)
    return Recording(
        f"{name}, {called}, {seed}", {"yaw_rate": (gyro, measured.round(6)), "torque": (commands, commanded.round(4))}
    )


def motion(kind: Kind, vehicle: Turning, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Times [s], yaw rate [rad/s] and torque [N m] by the midpoint rule."""
    size = round(LASTS_S / STEP_S)
    time: Array = STEP_S * np.arange(size, dtype=np.float64)
    water = kind.water * vehicle.torque * leng.lasting(1.0, STEP_S, size, rng)
    for _ in range(6):
        wave = np.sin(2.0 * np.pi * time / rng.uniform(5.0, 10.0) + rng.uniform(0.0, 6.3))
        water = water + kind.swell * vehicle.torque * wave / np.sqrt(3.0)
    command = _command(kind, vehicle, time, rng)
    rates, torques, r, psi, side, wanted, tau = [], [], 0.0, 0.0, 1.0, 0.0, 0.0
    every = max(round(1.0 / (kind.hertz * STEP_S)), 1)
    bandwidth = 0.3 * vehicle.torque / (vehicle.inertia * vehicle.rate)
    gains = vehicle.inertia * bandwidth**2, 1.4 * vehicle.inertia * bandwidth
    for k, (told, moment) in enumerate(zip(command.tolist(), water.tolist(), strict=True)):
        if k % every == 0:
            if kind.manoeuvre == "relay":
                side = -side if side * r > 0.6 * vehicle.rate else side
                tau = 0.8 * side * vehicle.torque
            elif kind.manoeuvre in ("heading", "station"):
                wanted = told if kind.manoeuvre == "heading" else 0.0
                off = (wanted - psi + np.pi) % (2.0 * np.pi) - np.pi
                tau = max(min(gains[0] * off - gains[1] * r, vehicle.torque), -vehicle.torque)
            else:
                tau = told
        rates.append(r)
        torques.append(tau)
        middle = r + 0.5 * STEP_S * (tau + moment - vehicle.damping(r)) / vehicle.inertia
        r += STEP_S * (tau + moment - vehicle.damping(middle)) / vehicle.inertia
        psi += STEP_S * middle
    return time, np.array(rates), np.array(torques)


def _command(kind: Kind, vehicle: Turning, time: Array, rng: np.random.Generator) -> Array:
    """The torque [N m] at (n,) times [s]; for a controller of the heading, the heading [rad]."""
    if kind.manoeuvre == "sine":
        period = float(rng.uniform(8.0, 20.0)) * vehicle.inertia * vehicle.rate / vehicle.torque
        return np.asarray(0.95 * vehicle.torque * np.sin(2.0 * np.pi * time / max(period, 10.0)))
    if kind.manoeuvre not in ("steps", "heading"):
        return np.zeros(time.size)
    low, high = (60.0, 180.0) if kind.manoeuvre == "heading" else kind.hold_s
    found, at = np.zeros(time.size), 0.0
    while at < time[-1]:
        size = float(rng.choice(TORQUE_SHARES) * rng.choice((-1.0, 1.0))) * vehicle.torque
        size = 0.0 if rng.random() < kind.rests else size
        found[time >= at] = rng.uniform(-np.pi, np.pi) if kind.manoeuvre == "heading" else size
        at += float(rng.uniform(low, high))
    return found


def verdicts_on(recording: Recording, inertia: float) -> list[Verdict]:
    """The verdict on each batch of a recording, with settings that are scaled to it."""
    signals = signals_for([recording], inertia, RATE_LIMIT)
    samples, _ = samples_of(recording, signals, None)
    settings = learner_for(samples)
    vehicle = Vehicle(signals.inertia, settings.rate_range, signals.smoothing)
    return [verdict for verdict, _ in checked_learner.follow(settings, vehicle, samples)]


def examine(case: Case) -> Record:
    """What the checks put aside of one recording."""
    verdicts = verdicts_on(recording_of(case), VEHICLES[case[1]].inertia)
    said = sorted({each.kind for verdict in verdicts for each in verdict.findings if each.decision > Decision.CLEAN})
    aside = sum(not verdict.learn for verdict in verdicts)
    about: Record = {"kind": case[0], "vehicle": case[1], "seed": case[2]}
    return about | {"batches": len(verdicts), "aside": aside, "said": said}


def report(results: Sequence[Record]) -> Iterable[str]:
    """A row for each kind, then all."""
    rows = [[kind, *_row(own)] for kind, own in grouped(results, "kind").items()]
    rows.append([f"**all {len(results)}**", *_row(results)])
    yield table(["kind", "recordings", "with a batch put aside", "batches put aside", "said"], rows)


def _row(own: Sequence[Record]) -> list[object]:
    said = [f"{kind} ({sum(kind in each['said'] for each in own)})" for kind in
            sorted({kind for each in own for kind in each["said"]})]  # fmt: skip
    aside, batches = (sum(each[name] for each in own) for name in ("aside", "batches"))
    return [len(own), sum(each["aside"] > 0 for each in own), f"{aside} of {batches}", ", ".join(said) or "–"]


def cases(asked: argparse.Namespace) -> list[Case]:
    """Every kind with every vehicle, twice a seed but for those at 5 and 10 Hz."""
    chosen = [kind for kind in KINDS if asked.only in kind]
    return [(kind, vehicle, seed) for kind, vehicle, seed in product(chosen, VEHICLES, seeds(asked))]


def main(words: Sequence[str] | None = None) -> None:
    run("quiet", __doc__, cases, examine, report, words, first_seed=(960_000, "of the recordings"),
        seeds=(2, "recordings of each kind and vehicle"), only=("", "part of a kind's name"))  # fmt: skip


if __name__ == "__main__":
    main()
