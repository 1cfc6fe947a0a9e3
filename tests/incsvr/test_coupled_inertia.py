"""M is that of a body, with entries off its diagonal, whether its actuators show them well or hardly."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.numerics import Array, Streams
from incsvr.vehicle import identify

MASS: Array = np.array([[140.0, 0.0, 0.0], [0.0, 330.0, 60.0], [0.0, 60.0, 180.0]])
"""The mass matrix of surge, sway and yaw [kg], [kg m], [kg m²]."""
DRAG: Array = np.array([[30.0, 0.0, 0.0], [0.0, 90.0, 20.0], [0.0, 10.0, 160.0]])
"""The damping matrix of the same axes [N s/m], [N s], [N m s]."""

TRUE = {("surge", "surge"): 140.0, ("sway", "sway"): 330.0, ("yaw", "yaw"): 180.0, ("sway", "yaw"): 60.0}


def resistance(state: Array, turning: bool) -> Array:
    """C(M) ν + D ν [N], [N m], without C(M) where the frame does not turn."""
    (u, v, r), (along, across, coupled) = state, (MASS[0, 0], MASS[1, 1], MASS[1, 2])
    coriolis = np.array([-(across * v + coupled * r) * r, along * u * r, (across - along) * u * v + coupled * u * r])
    return np.asarray(turning * coriolis + DRAG @ state)


def ship(
    seed: int, bow_thruster: bool, turning: bool = True, seconds: float = 500.0, step: float = 0.02, every: int = 10
) -> Streams:
    """A ship of linear drag, whose rudder makes a sway force and three times as much yaw moment against it.

    Args:
        turning: whether its frame is taken to turn, as that of a body does; simulators there are without C(ν).
    """
    random = np.random.default_rng(seed)
    count = round(seconds / step)
    holds = np.cumsum(random.uniform(2.0, 8.0, count // 100) / step).astype(int)
    which = np.searchsorted(holds, np.arange(count))
    ahead, rudder, bow = (
        random.uniform(low, 40.0, which.max() + 1)[which] for low in (0.0, -40.0, -40.0 if bow_thruster else 40.0)
    )
    side = bow if bow_thruster else np.zeros(count)
    efforts = np.column_stack((ahead, rudder + side, 2.0 * side - 3.0 * rudder))
    inverse, state, states = np.linalg.inv(MASS), np.zeros(3), np.empty((count, 3))
    for k, effort in enumerate(efforts):
        states[k] = state
        middle = state + 0.5 * step * (inverse @ (effort - resistance(state, turning)))
        state = state + step * (inverse @ (effort - resistance(middle, turning)))
    time: Array = step * np.arange(0, count, every, dtype=np.float64)
    seen = states[::every] + random.normal(0.0, (0.005, 0.005, 0.002), (time.size, 3))
    velocities, names = ("surge", "sway", "yaw_rate"), ("surge_force", "sway_force", "torque")
    return {name: (time, seen[:, k]) for k, name in enumerate(velocities)} | {
        name: (time, efforts[::every, k]) for k, name in enumerate(names)
    }


@pytest.mark.slow
@pytest.mark.parametrize("turning", [True, False])
@pytest.mark.parametrize("seed", [3, 4])
def test_two_actuators_show_all_of_it(seed: int, turning: bool) -> None:
    mass = identify([ship(seed, True, turning)], validate=False).vehicle.mass
    for pair, true in TRUE.items():
        assert mass[pair].low <= true <= mass[pair].high
        assert mass[pair].high - mass[pair].low < 0.3 * true


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 4])
def test_of_one_rudder_the_intervals_contain_it(seed: int) -> None:
    """Sway force and moment are proportional: a diagonal M would explain them, too, with another sway inertia."""
    mass = identify([ship(seed, bow_thruster=False)], validate=False).vehicle.mass
    for pair, true in TRUE.items():
        assert mass[pair].low <= true <= mass[pair].high
