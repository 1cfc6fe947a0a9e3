"""The second simulator's effects: how large they are, and that what is told of them is what acts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from simulator.second import EFFECTS, VEHICLES, Case, Played, play
from simulator.second.motion import Motion
from simulator.second.plant import STEP, Array
from simulator.second.play import chance, water

CHANNELS = ("sway", "voltage")
NAMES = (*EFFECTS, "coupling:sway", "modulation:voltage")
USUAL = Case(seed=4, vehicle="work_rov", command="noise_band", channels=CHANNELS, duration=240.0)


def held(motion: Motion) -> Array:
    """(n,) the command in force in each step [N m]."""
    return np.repeat(motion.command, motion.yaw_rate.size // motion.command.size)


@pytest.mark.parametrize("name", NAMES)
def test_an_effect_is_of_realistic_size_and_half_of_it_is_less(name: str) -> None:
    shares = [moment_of(replace(USUAL, effects=(name,), size=size)) for size in (0.5, 1.0)]
    assert 0.04 < shares[1] < 0.6
    assert 0.3 < shares[0] / shares[1] < 0.8


@pytest.mark.parametrize("name", [*NAMES, "modulation:depth"])
@pytest.mark.parametrize("seed", [4, 5])
def test_the_truth_that_is_told_is_what_acts(name: str, seed: int) -> None:
    """To the textbook's moment with the told parameters the hidden one is similar, in sign and size."""
    hidden = replace(USUAL, seed=seed, effects=(name,), channels=(*CHANNELS, "depth"), duration=480.0)
    played = play(hidden)
    textbook, acts = textbook_moment(name, hidden, played), unexplained(hidden, played.motion)
    assert 0.7 < textbook @ acts / (textbook @ textbook) < 1.4
    assert textbook @ acts > 0.8 * np.linalg.norm(textbook) * np.linalg.norm(acts)


def moment_of(hidden: Case) -> float:
    """What the declared vehicle leaves unexplained of its motion, over the usual command: root mean squares."""
    motion = play(hidden).motion
    return float(np.sqrt(np.mean(unexplained(hidden, motion) ** 2) / np.mean(motion.command**2)))


def unexplained(hidden: Case, motion: Motion) -> Array:
    """(n,) the moment that the declared vehicle, its command and the water leave over in each step [N m]."""
    vehicle, before = VEHICLES[hidden.vehicle], np.concatenate([[0.0], motion.yaw_rate[:-1]])
    pushed = held(motion) + water(vehicle, before.size, chance(hidden, "water"))
    left = vehicle.inertia * (motion.yaw_rate - before) / STEP + drag_of(hidden, 0.5 * (before + motion.yaw_rate))
    return np.asarray(left - pushed, dtype=np.float64)


def drag_of(hidden: Case, rates: Array) -> Array:
    """(n,) d(r) of the declared vehicle [N m]."""
    drag = VEHICLES[hidden.vehicle].drag()
    return np.array([drag(r) for r in rates.tolist()])


def textbook_moment(name: str, hidden: Case, played: Played) -> Array:
    """(n,) the moment of an effect as CONTRACT words it, with the parameters that the simulator tells [N m]."""
    told = {key: float(value) for key, value in played.truth[name].items() if not isinstance(value, str)}
    motion, u, r, heading = played.motion, held(played.motion), played.motion.yaw_rate, played.motion.heading
    time, drag = STEP * np.arange(r.size, dtype=np.float64), drag_of(hidden, r)
    inertia = VEHICLES[hidden.vehicle].inertia
    kind, _, channel = name.partition(":")

    def late(seconds: float) -> Array:
        return np.interp(time - seconds, time, u)

    def after(rise: Array, seconds: float) -> Array:
        decay = np.exp(-STEP / seconds)
        return np.asarray(lfilter([1.0 - decay], [1.0, -decay], rise))

    def away(origin: str) -> Array:
        stamps, values = played.recording.streams()[channel]
        return np.asarray(told["coefficient"] * (np.interp(time, stamps, values) - told[origin]))

    def within(width: float) -> Array:
        gear = played.truth[name]["shape"] == "gear"  # beyond the band it lacks the band, stiction lacks nothing
        return np.clip(u, -width, width) if gear else np.where(np.abs(u) < width, u, 0.0)

    moments: dict[str, Callable[[], Array]] = {
        "bias_torque": lambda: np.full(r.size, told["moment_nm"]),
        "inertia": lambda: (inertia - told["inertia_kg_m2"]) * np.gradient(r, STEP),
        "torque_lag": lambda: after(u, told["time_constant_s"]) - u,
        "torque_delay": lambda: late(told["delay_s"]) - u,
        "dead_zone": lambda: -within(told["half_width_nm"]),
        "torque_asymmetry": lambda: (told["reverse_efficiency"] - 1.0) * np.minimum(u, 0.0),
        "torque_saturation": lambda: told["limit_nm"] * np.tanh(u / told["limit_nm"]) - u,
        "inflow": lambda: -told["coefficient"] * r * np.sqrt(np.abs(motion.thrust)),
        "heading_current": lambda: told["amplitude_nm"] * np.sin(told["harmonic"] * heading + told["phase_rad"]),
        "tether": lambda: -told["stiffness_nm_per_rad"] * (heading - heading[0]),
        "wave": lambda: told["amplitude_nm"] * np.sin(2 * np.pi * time / told["period_s"] + told["phase_rad"]),
        "drag_drift": lambda: -told["fraction"] * time / time[-1] * drag,
        "drag_step": lambda: -told["fraction"] * (time > told["at_s"]) * drag,
        "memory": lambda: told["gain_nm_s"] * after(r, told["time_constant_s"]),
        "coulomb": lambda: -told["moment_nm"] * np.sign(r),
        "bias_drift": lambda: told["nm_per_s"] * time,
        "coupling": lambda: away("origin"),
        "modulation": lambda: away("reference") * (u if played.truth[name]["shape"] == "thrust" else -drag),
    }
    return moments[kind]()
