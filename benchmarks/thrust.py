"""Thrust that is lost under way: how soon, how large and how often falsely it is told.

In missions of half an hour, with the controller in the loop, one of two thrusters gives half or nothing from a drawn
instant on, and all again five minutes later. In quiet hours nothing happens. In logs of measured vehicles, one run
after the other, the command is doubled from a drawn instant on, so that the vehicle answers it as with half its thrust;
each is watched without that as well. *Driven* is time in which the torque is a tenth of its root mean square or more.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from benchmarks.study import MEASURED, Record, grouped, run, share, table
from incsvr.forecasting.thrust_watch import ThrustChange
from incsvr.numerics import root_mean_square
from incsvr.signals import TORQUE, YAW_RATE
from service.config.sources import read
from service.fitting.scaled import scaled_config
from service.learner.node import LearnerNode
from service.recordings.reading import RATE_LIMIT
from service.recordings.reading import read as read_recording
from service.recordings.recording import Recording, sequence
from service.recordings.samples_from_recording import learner_for, samples_of, signals_for
from simulator.mission import Mission
from simulator.physics import Array, Physics
from simulator.vehicles import TURNING
from simulator.world import play_together

VEHICLES = ("rov", "auv")
TURNS = ("survey", "waypoints", "zigzag", "pipeline", "rate_control")
"""Missions in which the vehicle turns: on a straight leg nobody can tell."""
QUIET = (*TURNS, "circles", "transit", "station", "one_sided", "bursts")
LOST = (0.25, 0.25, 0.5, 0.5)
"""Part of the thrust that is lost, of two vehicles each."""
MISSION_S, FAULT_S, HOUR_S, ONSETS_S, IN_TIME_S = 1800.0, 300.0, 3600.0, (600.0, 1200.0), 60.0
MEASURED_VEHICLES = {"bluerov": 1.125, "blueboat": 25.65}
"""Vehicles that were measured, and what was published of their inertia [kg m²]."""
TOGETHER = 10
"""Missions that are played together."""
CHUNK_S = 3.0
"""So much of each stream comes at once [s]."""
Case = tuple[str, range]
"""Group and seeds, whose missions are played together: many cost little more than one."""


def examine(case: Case) -> list[Record]:
    """Some missions, or some logs."""
    group, seeds = case
    if group in MEASURED_VEHICLES:
        return [{"group": group, "seed": seed} | _measured(group, seed) for seed in seeds]
    drawn = [_quiet(seed) if group == "quiet hour" else _broken(seed) for seed in seeds]
    records = []
    for (mission, about), outcome in zip(drawn, play_together([mission for mission, _ in drawn]), strict=True):
        found, recording = watched(outcome.recording, outcome.inertia), outcome.recording
        onset = about.get("onset", np.inf)
        told: Record = {"false": [_plain(each) for each in found]}
        if np.isfinite(onset):
            told = judged(found, recording, onset, onset + FAULT_S)
        records.append({"group": group, "kind": mission.kind, "seed": mission.seed} | about | told)
    return records


def _quiet(seed: int) -> tuple[Mission, Record]:
    vehicle = VEHICLES[seed % 2]
    mission = Mission(TURNING[vehicle], QUIET[seed // 2 % len(QUIET)], seed, duration=HOUR_S)
    return mission, {"vehicle": vehicle}


def _broken(seed: int) -> tuple[Mission, Record]:
    random = np.random.default_rng([seed, *b"thrust"])
    vehicle, lost, kind = VEHICLES[seed % 2], LOST[seed % 4], str(random.choice(TURNS))
    onset = float(round(random.uniform(*ONSETS_S), 1))

    def part(t: Array) -> Array:
        return np.where((t >= onset) & (t < onset + FAULT_S), 1.0 - lost, 1.0)

    mission = Mission(TURNING[vehicle], kind, seed, duration=MISSION_S, besides=Physics(thrust=(part,)))
    return mission, {"vehicle": vehicle, "lost": lost, "onset": onset}


def _measured(vehicle: str, seed: int) -> Record:
    random = np.random.default_rng([seed, *b"thrust"])
    runs = [read_recording(path) for path in sorted((MEASURED / vehicle).glob("*.csv"))]
    runs = [each for each in runs if float(np.nanstd(each.effort)) > 0.0]
    whole = sequence([runs[k] for k in random.permutation(len(runs))])
    onset = float(round(random.uniform(0.5, 0.8) * whole.time[-1], 1))
    time, torque = whole.own_streams[TORQUE]
    drawn = np.where(time >= onset, 2.0, 1.0) * torque
    broken = replace(whole, own_streams={**whole.own_streams, TORQUE: (time, drawn)})
    found, quiet = (watched(each, MEASURED_VEHICLES[vehicle]) for each in (broken, whole))
    about: Record = {"kind": "log", "vehicle": vehicle, "lost": 0.5, "onset": onset}
    told = judged(found, broken, onset, np.inf)
    return about | told | {"false": told["false"] + [_plain(each) for each in quiet]}


def watched(recording: Recording, inertia: float) -> list[ThrustChange]:
    """What a learner finds that was configured as `incsvr fit --write` does it on this recording."""
    signals = signals_for([recording], inertia, RATE_LIMIT)
    samples, _ = samples_of(recording, signals, None)
    config = scaled_config(read(None, {"state": None}), recording, signals, learner_for(samples))
    node, found = LearnerNode(config, boot=""), list[ThrustChange]()
    streams = {name: recording.streams()[name] for name in (YAW_RATE, TORQUE)}
    for start in np.arange(0.0, float(recording.time[-1]) + CHUNK_S, CHUNK_S).tolist():
        for name, (t, value) in streams.items():
            here = slice(*np.searchsorted(t, [start, start + CHUNK_S]))
            if t[here].size:
                node.push(name, t[here], value[here])
        while node.learn() is not None:
            pass
        found += [] if node.thrust is None else node.thrust.take()
    return found


def judged(found: Sequence[ThrustChange], recording: Recording, onset: float, end: float) -> Record:
    """What was told of a fault from an onset to an end [s], and what besides."""
    lost = next((each for each in found if onset <= each.seen <= end and not each.is_back), None)
    back = next((each for each in found if each.seen > end and each.is_back), None)
    record: Record = {"told": None, "back": None if back is None else back.seen - end}
    if lost is not None:
        t, torque = recording.streams()[TORQUE]
        drives = (t >= onset) & (t < lost.seen) & (np.abs(torque) >= 0.1 * root_mean_square(torque))
        record |= {"told": lost.seen - onset, "size": 1.0 - lost.level[0]}
        record |= {"driven": float(np.median(np.diff(t)) * drives.sum())}
    return record | {"false": [_plain(each) for each in found if each.seen < onset]}


def _plain(change: ThrustChange) -> Record:
    return {"since": change.since, "seen": change.seen, "level": change.level[0], "odds": change.log_odds}


def report(groups: Sequence[Sequence[Record]]) -> Iterator[str]:
    """Faults by what is lost, and false events."""
    rows, results = [], [each for group in groups for each in group]
    for (group, lost), own in grouped([each for each in results if "told" in each], "group", "lost").items():
        told = [each for each in own if each["told"] is not None]
        in_time, plainly = (sum(each[of] <= IN_TIME_S for each in told) for of in ("driven", "told"))
        off = [abs(each["size"] - lost) for each in told]
        rows.append([
            group, f"{100 * lost:.0f} %", share(in_time, len(own)), plainly, len(told),
            f"{np.median(off):.2f}, {max(off):.2f}" if off else "–",
            "–" if group in MEASURED_VEHICLES else f"{sum(each['back'] is not None for each in own)} of {len(own)}",
        ])  # fmt: skip
    head = [
        "",
        "lost",
        f"told within {IN_TIME_S:.0f} s of driven data",
        "of any data",
        "told",
        "size off: median, most",
    ]
    yield table([*head, "return told"], rows)
    for group, own in grouped(results, "group").items():
        false = [f"{each['kind']}, {each['vehicle']}, {each['seed']}" for each in own if each["false"]]
        yield f"{group}: {len(false)} of {len(own)} with a false event{': ' * bool(false)}{'; '.join(false)}."


def cases(asked: argparse.Namespace) -> list[Case]:
    """Missions with a fault, quiet hours, and logs of each measured vehicle."""
    counts = {"mission": asked.faults, "quiet hour": asked.quiet}
    counts |= {name: asked.measured for name in MEASURED_VEHICLES if (MEASURED / name).is_dir()}
    first = {group: asked.first_seed + 1000 * k for k, group in enumerate(counts)}
    return [
        (group, range(first[group] + n, first[group] + min(n + TOGETHER, count)))
        for group, count in counts.items()
        for n in range(0, count, TOGETHER)
    ]


def main(words: Sequence[str] | None = None) -> None:
    run("thrust", __doc__, cases, examine, report, words, first_seed=(3_700_000, "of the missions"),
        faults=(20, "missions with a fault"), quiet=(20, "quiet hours"),
        measured=(5, "logs of each measured vehicle"))  # fmt: skip


if __name__ == "__main__":
    main()
