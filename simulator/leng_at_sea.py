"""Leng in the world, with its own water, thrusters and sensors: a beginner's log, and the third act of the demo.

In that act Leng with its hull goes on, and under way something breaks that nobody is told of. A seed draws what comes
on (one of EFFECTS, of realistic size), when, and how the vehicle is driven. The streams hold yaw rate and torque alone:
the torque as the rotors' told speeds make it in a vehicle that is sound.
"""

from __future__ import annotations

from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.numerics import Array
from incsvr.signals import YAW_RATE
from service.recordings.recording import Recording
from service.recordings.recording_csv import write
from simulator import leng
from simulator.mission import TICK_S, Mission
from simulator.physics import Course, Physics, static
from simulator.plans import OPEN_LOOP, Plan
from simulator.vehicles import TURNING
from simulator.world import Outcome, play

MAX_TORQUE = TURNING["leng"].torque
"""Both thrusters' moment at full speed [N m]."""
LOG_DURATION = 300.0
"""Length of a beginner's log [s]: `fit` learns from it in a second, `trace` in some ten."""
REVERSE_EFFICIENCY = 0.7
"""The part of a moment to port (negative) that the log's vehicle makes of what its rotors' speeds show."""
EFFECTS = ("dead_zone", "torque_asymmetry", "torque_saturation", "bias_torque", "inertia")
"""What may come on: thrusters that turn at large commands only, or give less astern or at full command; a fin that
bends; a payload. Not thrusters that begin to lag: the checks of the streams take that for a clock that jumped."""
ACT_DURATION = 800.0
"""[s]"""
SOUND = (60.0, 90.0)
"""For so long all is as it was [s]; the seed draws."""
UNIT_S = leng.INERTIA * leng.MAX_RATE / MAX_TORQUE
"""I r/τ [s]."""
PULL = 2.0 * leng.BOW.lever * leng.BOW.thrust
"""Both thrusters' moment by the rotor speed squared [N m s²/rad²]."""
INFLOW = 2.0 * leng.BOW.lever**2 * leng.BOW.inflow
"""What a turn takes of it, by rotor and yaw rate [N m s²/rad²]."""


def write_log(path: Path, seed: int) -> float:
    """Writes a beginner's log, Leng steered by steps and sines at once, with weak thrust to port; returns the vehicle's
    inertia [kg m²].

    Raises:
        OSError: the file cannot be written.
    """
    weak = static(lambda moment: moment if moment > 0.0 else REVERSE_EFFICIENCY * moment)
    told = steps_and_sines(LOG_DURATION, np.random.default_rng([seed, *b"log"]))
    write(path, at_sea(path.stem, told, seed, besides=Physics(stages=(weak,)))[0])
    return leng.INERTIA


def steps_and_sines(duration: float, random: np.random.Generator) -> Array:
    """Torques at the ticks, levels and several sines at once, so that all commands occur [N m]."""
    time: Array = np.arange(0.0, duration - 1e-9, TICK_S, dtype=np.float64) / UNIT_S
    levels, sines = (OPEN_LOOP[kind](time, random) for kind in ("telegraph", "multisine"))
    return np.asarray(0.5 * MAX_TORQUE * (levels + sines))


def at_sea(
    name: str,
    told: Array,
    seed: int,
    *,
    besides: Physics | None = None,
    hidden: tuple[str, ...] = (),
    onset: float = 0.0,
    hull: bool = False,
) -> tuple[Recording, Outcome]:
    """Leng as its sensors record it, and what truly happened.

    Args:
        name: of the recording.
        told: (n,) what the rotors are told at the ticks, as the moment that it makes at rest [N m].
        seed: draws the water, the wavering, the sensors and the effects.
        besides: what is hidden besides.
        hidden: names of effects that come on.
        onset: when [s].
        hull: whether the hull is mounted.
    """
    for_water, for_sensors = (
        np.random.default_rng(each) for each in np.random.SeedSequence([seed, *b"steered"]).spawn(2)
    )
    own = Physics(losses=(_inflow,), outside=(_lasting(leng.WATER, leng.WATER_MEMORY, told.size, for_water),))
    for share in leng.WAVERING[hull]:
        own += Physics(thrust=(_lasting(0.5 * share, leng.WAVERING_MEMORY, told.size, for_water, 1.0),))
    own += Physics(drag=(lambda t: np.full(t.size, 1.0 + leng.HULL * hull),)) + (besides or Physics())
    outcome = play(
        Mission(
            TURNING["leng"], "holds", seed, hidden, onset=onset, besides=own, beats=1.0 / TICK_S, water=0.0,
            duration=told.size * TICK_S, asked=Plan("torque", told),
        )
    )  # fmt: skip
    speed = np.sign(told) * np.sqrt(np.abs(told) / PULL)
    recording = leng.sensed(name, outcome.time, outcome.true(YAW_RATE), (speed, -speed), for_sensors)
    return recording, outcome


def _lasting(size: float, memory: float, ticks: int, random: np.random.Generator, about: float = 0.0) -> Course:
    """A process that lasts, at the ticks and straight between them."""
    values = about + size * leng.lasting(memory, TICK_S, ticks + 1, random)
    time: Array = TICK_S * np.arange(ticks + 1, dtype=np.float64)
    return lambda t: np.interp(t, time, values)


def _inflow(thrust: float, rate: float) -> float:
    """What a turn takes of a moment at rest [N m]."""
    return -INFLOW * sqrt(abs(thrust) / PULL) * rate


def third_act(seed: int) -> tuple[Recording, dict[str, Any]]:
    """The third act that a seed draws, and its truth.

    The truth is what came on, since when on the recording's clock [s], with which parameters; and commands up to half
    above the highest, each with the moment that acts at rest [N m], none of an effect beside the thrusters.
    """
    random = np.random.default_rng([seed, *b"underway"])
    effect, onset = str(random.choice(EFFECTS)), float(round(random.uniform(*SOUND)))
    told = steps_and_sines(ACT_DURATION, random)
    recording, outcome = at_sea("T3", told, seed, hidden=(effect,), onset=onset, hull=True)
    thrust = list[tuple[float, float]]()
    for asked in (np.linspace(-1.5, 1.5, 31) * MAX_TORQUE).tolist() if outcome.hidden.stages else ():
        moment = asked
        for stage in outcome.hidden.stages:
            moment = stage(moment)(moment)
        thrust.append((asked, moment))
    return recording, {"effect": effect, "since": onset, "parameters": outcome.truth[effect], "thrust_nm": thrust}
