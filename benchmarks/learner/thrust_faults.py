"""Thrust that is lost under way: how soon, how large and how often falsely the learner tells it.

In missions of half an hour, with the controller in the loop, one of two thrusters gives half or nothing from an instant
on that the seed draws, and all again five minutes later. In quiet hours nothing happens. In other recordings an effect
that the model lacks acts from the beginning on, which is no fault either. In logs of measured vehicles the logged
command of a span is made so much larger that the vehicle answers it as with a thruster at half. The learner is
configured as `incsvr fit --write` does it, on the recording itself. A seed names a mission.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmarks.study import MEASURED, Record, begin, in_processes, options, publish, revision
from benchmarks.tables import grouped, page, table
from benchmarks.tracer.live_missions import EFFECTS
from incsvr.forecasting.thrust_watch import ThrustChange
from service.commands.config_output import scaled_config
from service.config.sources import read
from service.learner.node import LearnerNode
from service.recordings.recording import Recording, sequence
from service.recordings.recording_csv import RATE_LIMIT
from service.recordings.recording_csv import read as read_recording
from service.recordings.samples_from_recording import learner_for, samples_of, signals_for
from simulator import leng
from simulator.missions import Mission, play
from simulator.steered import leng_log
from simulator.trial_effects import Physics
from simulator.trial_vehicle import STEP

VEHICLES = ("rov", "auv")
FAULT_KINDS = ("survey", "waypoints", "zigzag", "pipeline", "rate_control")
"""Missions in which the vehicle turns: on a straight leg nobody can tell."""
QUIET_KINDS = (*FAULT_KINDS, "circles", "transit", "station", "day", "wagging", "bursts", "one_sided")
LOST = {"half": 0.25, "none": 0.5}
"""Part of the yaw thrust that two thrusters lose when one gives half, or none."""
MISSION_S, FAULT_S, HOUR_S = 1800.0, 300.0, 3600.0
MIN_ONSET_S, MAX_ONSET_S = 600.0, 1200.0
"""Earliest and latest onset [s]."""
IN_TIME_S = 60.0
"""[s]"""
MIN_TORQUE_SHARE = 0.1
"""Part of the usual torque from which on a second counts as one in which the vehicle is driven."""
CHUNK_S = 3.0
"""So much of each stream comes at once [s]."""
MEASURED_VEHICLES = {"bluerov": 1.125, "blueboat": 25.65}
"""Vehicles that were measured, and what was published of their inertia [kg m²]."""
MEASURED_LOST = 0.5
"""Part of the thrust that is lost in a measured log."""


def examine(case: tuple[str, int, float]) -> Record:
    """One case of a group, with a controller of this rate [Hz] where it is a mission."""
    group, seed, control_rate = case
    began = time.process_time()
    missions = {"fault": _fault, "quiet": _quiet, "lasting": _lasting}
    record = missions[group](seed, control_rate) if group in missions else _measured(group, seed)
    return {"group": group, "seed": seed, **record, "seconds": round(time.process_time() - began, 1)}


def _fault(seed: int, control_rate: float) -> Record:
    random = np.random.default_rng([seed, *b"thrust"])
    vehicle, thruster = VEHICLES[seed % 2], ("half", "none")[seed // 2 % 2]
    kind, lost = str(random.choice(FAULT_KINDS)), LOST[thruster]
    onset = float(round(random.uniform(MIN_ONSET_S, MAX_ONSET_S), 1))
    first, last = (2 * round(t / STEP) for t in (onset, onset + FAULT_S))

    def weak(moment: float, _rate: float, tick: int) -> float:
        return (1.0 - lost) * moment if first <= tick < last else moment

    def breaking(sound: Physics) -> Physics:
        return replace(sound, commanded=(*sound.commanded, weak))

    outcome = play(Mission(kind, vehicle, seed, duration=MISSION_S, control_rate=control_rate), breaking)
    found = watched(outcome.recording, outcome.inertia)
    about = {"kind": kind, "vehicle": vehicle, "thruster": thruster, "lost": lost, "onset": onset}
    return about | judged(found, outcome.recording, onset, onset + FAULT_S)


def _quiet(seed: int, control_rate: float) -> Record:
    kind, vehicle = QUIET_KINDS[seed // 2 % len(QUIET_KINDS)], VEHICLES[seed % 2]
    separate = seed % 3 == 0
    outcome = play(Mission(kind, vehicle, seed, duration=HOUR_S, separate_gyro=separate, control_rate=control_rate))
    found = watched(outcome.recording, outcome.inertia)
    return {"kind": kind, "vehicle": vehicle, "separate_gyro": separate, "false": [_plain(each) for each in found]}


def _lasting(seed: int, control_rate: float) -> Record:
    """Half an hour with an effect that the model lacks from its beginning on, or the log of `incsvr demo --log`."""
    if seed % 2:
        recording, inertia = leng_log(f"leng {seed}", seed), leng.INERTIA
        return {"kind": "log", "vehicle": "leng", "false": [_plain(each) for each in watched(recording, inertia)]}
    random = np.random.default_rng([seed, *b"lasting"])
    kind, vehicle, effect = (str(random.choice(names)) for names in (FAULT_KINDS, VEHICLES, EFFECTS))
    outcome = play(Mission(kind, vehicle, seed, effect, duration=MISSION_S, control_rate=control_rate))
    found = watched(outcome.recording, outcome.inertia)
    return {"kind": f"{kind} with {effect}", "vehicle": vehicle, "false": [_plain(each) for each in found]}


def _measured(group: str, seed: int) -> Record:
    """A log of all runs one after the other; the command of its last third is that of a vehicle with less thrust."""
    random = np.random.default_rng([seed, *b"thrust"])
    runs = [read_recording(path) for path in sorted((MEASURED / group).glob("*.csv"))]
    runs = [run for run in runs if float(np.nanstd(run.columns["torque"])) > 0.0]
    whole = sequence([runs[k] for k in random.permutation(len(runs))])
    end = float(whole.time[-1])
    onset = float(round(random.uniform(0.5, 0.8) * end, 1))
    late = whole.time >= onset
    columns = dict(whole.columns)
    columns["torque"] = np.where(late, columns["torque"] / (1.0 - MEASURED_LOST), columns["torque"])
    broken = Recording(whole.name, whole.time, columns)
    quiet = watched(whole, MEASURED_VEHICLES[group])
    found = watched(broken, MEASURED_VEHICLES[group])
    about = {"lost": MEASURED_LOST, "onset": onset, "false": [_plain(each) for each in quiet]}
    return about | judged(found, broken, onset, np.inf)


def watched(recording: Recording, inertia: float) -> list[ThrustChange]:
    """What a learner of this recording finds of the thrust."""
    signals = signals_for([recording], inertia, RATE_LIMIT)
    samples, _ = samples_of(recording, signals, None)
    config = scaled_config(read(None, {"state": None}), recording, signals, learner_for(samples))
    node = LearnerNode(config, boot="")
    streams = {name: recording.streams()[name] for name in ("yaw_rate", "torque")}
    found: list[ThrustChange] = []
    for start in np.arange(0.0, float(recording.time[-1]) + CHUNK_S, CHUNK_S).tolist():
        for name, (t, value) in streams.items():
            here = slice(*np.searchsorted(t, [start, start + CHUNK_S]))
            if t[here].size:
                node.push(name, t[here], value[here])
        while node.learn() is not None:
            pass
        if node.thrust is not None:
            found += node.thrust.take()
    return found


def judged(found: Sequence[ThrustChange], recording: Recording, onset: float, end: float) -> Record:
    """What was told of a fault from an onset to an end [s], and what besides."""
    lost = next((each for each in found if onset <= each.seen <= end and not each.is_back), None)
    back = next((each for each in found if each.seen > end and each.is_back), None)
    record: Record = {"told": lost is not None, "back": None if not np.isfinite(end) else back is not None}
    if lost is not None:
        record |= _plain(lost) | {"after": lost.seen - onset, "driven_after": _driven(recording, onset, lost.seen)}
    if back is not None:
        record |= {"back_after": back.seen - end, "back_driven_after": _driven(recording, end, back.seen)}
    return record | {"before": [_plain(each) for each in found if each.seen < onset]}


def _driven(recording: Recording, begins: float, ends: float) -> float:
    """For how much of a time the torque drives the vehicle [s]."""
    t, torque = recording.streams()["torque"]
    usual = float(np.sqrt(np.mean(torque**2)))
    here = (t >= begins) & (t < ends)
    return float(np.median(np.diff(t))) * float(np.sum(np.abs(torque[here]) >= MIN_TORQUE_SHARE * usual))


def _plain(change: ThrustChange) -> Record:
    return {"since": change.since, "seen": change.seen, "level": change.level[0], "odds": change.log_odds,
            "leads": dict(change.leads)}  # fmt: skip


def report(document: Record) -> str:
    """Markdown."""
    groups = grouped(document["records"], "group")
    parts = [
        "# Thrust that is lost under way",
        f"Made by `{document['command']}` on {document['date']}, revision {document['revision']}.",
        " ".join(__doc__.split("\n\n")[1].split()),
    ]
    if "fault" in groups:
        parts += ["## Missions with a fault", _faults(groups["fault"])]
    for vehicle in MEASURED_VEHICLES.keys() & groups.keys():
        parts += [f"## The measured {vehicle}", _faults(groups[vehicle])]
    for group, title in {"quiet": "Quiet hours", "lasting": "An effect from the beginning on"}.items():
        if group in groups:
            quiet = groups[group]
            false = [f"{each['kind']} {each['vehicle']} {each['seed']}" for each in quiet if each["false"]]
            parts += [f"## {title}", f"{len(false)} of {len(quiet)} with a fault told: {', '.join(false) or 'none'}."]
    return page(*parts)


def _faults(records: Sequence[Record]) -> str:
    rows = []
    for each in records:
        told, dash = each["told"], "–"
        rows.append(
            [
                each["seed"],
                each.get("kind", "log"),
                each.get("vehicle", each["group"]),
                f"{each['lost']:.2f}",
                *(
                    (
                        f"{each['after']:.0f}",
                        f"{each['driven_after']:.0f}",
                        f"{1.0 - each['level']:.2f}",
                        f"{each['since'] - each['onset']:+.0f}",
                    )
                    if told
                    else (dash,) * 4
                ),
                f"{each['back_after']:.0f}" if each.get("back") else dash,
                len(each["before"]) + len(each.get("false", [])),
            ]
        )
    in_time = sum(each["told"] and each["driven_after"] <= IN_TIME_S for each in records)
    plainly = sum(each["told"] and each["after"] <= IN_TIME_S for each in records)
    back = sum(bool(each.get("back")) for each in records)
    head = ["seed", "mission", "vehicle", "lost", "told after [s]", "of it driven [s]", "told", "onset off by [s]",
            "back told after [s]", "else"]  # fmt: skip
    said = (
        f"Told within {IN_TIME_S:g} s of driven data: {in_time} of {len(records)}; within {IN_TIME_S:g} s of any data: "
        f"{plainly}. Its return told: {back}."
    )
    return f"{said}\n\n{table(head, rows)}"


def main(words: list[str] | None = None) -> int:
    parser = options(
        "benchmarks.learner.thrust_faults", __doc__,
        faults=(20, "missions with a fault"), quiet=(40, "quiet hours"),
        lasting=(40, "recordings with an effect from their beginning on"),
        measured=(5, "logs of each measured vehicle"),
        first_seed=(3_500_000, "first seed"), processes=(1, "processes"),
        control_rate=(10.0, "commands a second in the missions; 40 at most, of whole steps of the simulation"),
    )  # fmt: skip
    given, document = begin(parser, words)
    groups = [("fault", given.faults), ("quiet", given.quiet), *((name, given.measured) for name in MEASURED_VEHICLES),
              ("lasting", given.lasting)]  # fmt: skip
    cases = [
        (group, given.first_seed + 1000 * k + n, given.control_rate)
        for k, (group, count) in enumerate(groups)
        for n in range(count)
    ]
    records = in_processes(examine, cases, "thrust faults", given.processes)
    document |= {"revision": revision(), "records": records}
    name = "thrust_faults" if given.control_rate == 10.0 else f"thrust_faults_{given.control_rate:g}_hz"
    publish(given.out, name, document, report(document))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
