"""How the torque runs between its stamps is asked again beside all effects that were found."""

from __future__ import annotations

import numpy as np

from incsvr.effects import candidates
from incsvr.tracer.alignment import aligned, misread, reread, with_share
from incsvr.tracer.hypothesis import nothing, settle
from incsvr.tracer.posing import pose
from incsvr.tracer.run import Array, Run
from simulator.trial import Trial, play

INERTIA, PERIOD, FINE, DELAY, GAIN = 350.0, 0.2, 0.01, 0.4, 40.0
EVERY = round(PERIOD / FINE)


def driven(seed: int, *, held: bool) -> Run:
    """Thrust DELAY behind a torque that is held between its stamps, or goes on; a swaying channel turns more."""
    random = np.random.default_rng(seed)
    time: Array = np.linspace(0.0, 600.0, round(600.0 / FINE) + 1)
    periods, phases = random.uniform(0.8, 20.0, 6), random.uniform(0.0, 6.28, 6)
    command: Array = 15.0 * np.sum([np.sin(6.283 * time / p + a) for p, a in zip(periods, phases, strict=True)], axis=0)
    torque = np.repeat(command[::EVERY], EVERY)[: time.size] if held else command
    sway: Array = np.sin(6.283 * time / 7.0) + 0.5 * np.sin(6.283 * time / 11.3)
    behind = round(DELAY / FINE)
    thrust = np.concatenate([np.full(behind, torque[0]), torque[:-behind]]) + GAIN * sway
    rate, now = np.zeros(time.size), 0.0
    for k, moment in enumerate(thrust.tolist()):
        rate[k] = now
        now += FINE / INERTIA * (moment - 120.0 * now - 700.0 * now * abs(now))
    seen = slice(None, None, EVERY)
    count = time[seen].size
    return Run(
        "driven", time[seen], rate[seen] + random.normal(0.0, 2e-4, count),
        command[seen] + random.normal(0.0, 0.5, count), {"sway": sway[seen]},
    )  # fmt: skip


def test_the_two_torques_are_compared_in_the_same_blocks() -> None:
    """Held, the noise of this torque asks for shorter blocks: what was left in those seemed to be less."""
    effects = ("coupling:sway", "tether")
    outcome = play(Trial(330_017, effects, vehicle="leng", excitation="closed_loop", autocorrelation=0.5))
    columns = dict(outcome.recording.columns)
    run = Run("loop", outcome.recording.time, columns.pop("yaw_rate"), columns.pop("torque"), columns)
    problem, linear = aligned([run], outcome.inertia, ["sway"])
    assert problem is linear
    alone = pose([run], outcome.inertia, ["sway"], held=True)
    assert len(alone.blocks) != len(linear.blocks)


def test_a_command_that_is_told_but_beside_the_effects_is_asked_for_again() -> None:
    """Levels behind a limit and a slow rotor: without these the torque's noise seems to turn the vehicle late."""
    outcome = play(Trial(345_014, ("torque_saturation", "torque_lag"), 1.0, "leng", "telegraph", 0.5, noise="torque"))
    columns = outcome.recording.columns
    run = Run("jumping", outcome.recording.time, columns["yaw_rate"], columns["torque"], {})
    problem = with_share(pose([run], outcome.inertia, []), 1.0)
    base = nothing(problem)
    assert not reread([run], problem, base).signals.known
    by_key = {effect.key: effect for effect in candidates()}
    limit, lag = by_key["torque_saturation/limit"], by_key["torque_lag/rotor speed, commanded"]
    found = settle(problem, [(limit, (72.0,), ()), (lag, (0.6,), ())], base, passes=10)
    again = reread([run], problem, found)
    assert again.signals.known
    assert misread(problem, again, 1.0)
    assert misread(again, problem, 1.0)
