"""The world: missions of vehicles side by side, with what they hide, their water, their controllers and their sensors.

Truth is integrated at 2 ms. Every 20 ms sensors hand over what they sampled meanwhile, and a controller whose beat it
is says efforts that hold until its next. Everything follows from the seed of a mission, and every kind of chance has a
stream of its own: the same mission with an effect more is the same in everything else, whatever is played beside it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.numerics import Array
from incsvr.plant.attitude import rotation
from service.recordings.recording import Recording
from simulator.hull import Hulls
from simulator.mission import BLOCK, TICK, TICK_S, Mission, Ship
from simulator.physics import STEP, Physics, Truth
from simulator.sensors import EFFORT, HEADING, QUANTITIES, Log
from simulator.vehicles import YAW


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of a mission.

    Attributes:
        mission: what was played.
        recording: what the vehicle logged.
        hidden: what came on.
        truth: the parameters of each hidden effect by its name.
        time: (n,) of the ticks [s].
        motion: (n, 15) QUANTITIES there, as they truly were; the efforts are those commanded.
        water_rms: deviation of the water's push (6,) [N], [N m].
    """

    mission: Mission
    recording: Recording
    hidden: Physics
    truth: Mapping[str, Truth]
    time: Array
    motion: Array
    water_rms: Array

    @property
    def inertia(self) -> float:
        """What the operator declares [kg m²]."""
        return self.mission.vehicle.inertia

    def damping(self, rates: Array) -> Array:
        """The true d(r) [N m], without what is hidden."""
        return self.mission.vehicle.damping(rates)

    def true(self, quantity: str) -> Array:
        """(n,) one of QUANTITIES."""
        return self.motion[:, QUANTITIES.index(quantity)]


def play(mission: Mission) -> Outcome:
    """One mission by itself."""
    return play_together([mission])[0]


def play_together(missions: Iterable[Mission]) -> list[Outcome]:
    """Missions side by side: many cost little more than one.

    Raises:
        KeyError: a kind, an effect, a list or a channel that does not exist.
        ValueError: a controller's period is no whole number of ticks.
    """
    ships = [Ship(mission) for mission in missions]
    missions = [ship.mission for ship in ships]
    hulls = Hulls([mission.vehicle for mission in missions], np.array([ship.heading for ship in ships]))
    log, last = Log([ship.samples() for ship in ships]), max(ship.ticks for ship in ships)
    truth = np.zeros((last, len(ships), len(QUANTITIES)))
    # The tick before, at its steps: what sensors sampled.
    chunk = np.zeros((TICK + 1, len(ships), len(QUANTITIES)))
    chunk[:, :, 6:9] = hulls.attitude()
    _over_ground(missions, chunk)
    outside = np.empty(0)
    for tick in range(last):
        log.take(tick * TICK_S, TICK_S, chunk)
        efforts = chunk[-1, :, EFFORT:].copy()
        for k, ship in enumerate(ships):
            if tick % BLOCK == 0 and tick in ship.changes:
                ship.change(tick, k, hulls, float(efforts[k, YAW]))
            if tick % ship.every == 0 and tick < ship.ticks:
                efforts[k] = ship.pilot(tick // ship.every, float(log.seen[k, YAW]), float(log.seen[k, HEADING]))
        truth[tick] = chunk[-1]
        truth[tick, :, EFFORT:] = chunk[:, :, EFFORT:] = efforts
        if tick % BLOCK == 0:
            time = tick * TICK_S + STEP * np.arange(BLOCK * TICK, dtype=np.float64)
            outside = np.stack([ship.block(time) for ship in ships], axis=1)
        first = tick % BLOCK * TICK
        pushes = STEP * np.einsum("nij,snj->sni", hulls.inverse, outside[first : first + TICK] + efforts)
        _advance(ships, hulls, pushes, chunk, first)
    log.take(last * TICK_S, TICK_S, chunk)
    clock: Array = TICK_S * np.arange(last, dtype=np.float64)
    found = []
    for k, ship in enumerate(ships):
        own = truth[: ship.ticks, k]
        recording = ship.recording(log.values[k], own[:: ship.every, EFFORT:])
        found.append(
            Outcome(ship.mission, recording, ship.hidden, ship.truth, clock[: ship.ticks], own, ship.water_rms)
        )
    return found


def _advance(ships: Sequence[Ship], hulls: Hulls, pushes: Array, chunk: Array, first: int) -> None:
    """The steps of a tick, in which pushes (TICK, n, 6) act and what each yaw adds; they fill the chunk.

    Args:
        first: step of the block at which the tick begins.
    """
    velocity, start = hulls.state[:, :6], chunk[-1, :, 6:9].copy()
    turning = [
        (k, ship.yaw, float(chunk[0, k, EFFORT + YAW]), STEP * hulls.inverse[k, :, YAW])
        for k, ship in enumerate(ships)
        if ship.yaw is not None
    ]
    heading = start[:, 2].tolist()
    chunk[0, :, :6] = velocity
    for step, push in enumerate(pushes):
        for k, yaw, asked, gain in turning:
            rate = velocity.item(k, YAW)
            push[k] += yaw.besides(first + step, asked, rate, heading[k]) * gain
            heading[k] += STEP * rate
        hulls.step(push)
        chunk[step + 1, :, :6] = velocity
    end = hulls.attitude()
    end[:, 2] = start[:, 2] + (end[:, 2] - start[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    chunk[:, :, 6:9] = np.linspace(start, end, TICK + 1)
    _over_ground([ship.mission for ship in ships], chunk)


def _over_ground(missions: Sequence[Mission], chunk: Array) -> None:
    """Adds the water's velocity to those through the water."""
    for k, mission in enumerate(missions):
        if any(mission.current):
            current = np.array([*mission.current, 0.0])
            first, last = (rotation(*chunk[place, k, 6:9]).T @ current for place in (0, -1))
            chunk[:, k, :3] += np.linspace(first, last, TICK + 1)
