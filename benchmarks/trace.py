"""What the tracer names of hidden effects, and of nothing.

Twelve minutes a case. Effects of both lists, of which nobody fitted on the second, in vehicles of its own; a torque
that is the command, and one that is measured. An effect is found where it is named, or where the one that is named says
that this recording cannot tell it from the hidden one.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from benchmarks.study import Record, grouped, run, share, table
from incsvr.errors import BadInput
from incsvr.tracing.result import trace
from service.fitting.trace import runs_of
from service.recordings.recording import Recording
from simulator.mission import EFFECTS, LISTS, ON_CHANNEL, Mission
from simulator.sensors import CHANNELS, Sensor, own_clocks, torque_sensor
from simulator.vehicles import SECOND, TURNING, Vehicle
from simulator.world import play

GROUPS = {"one": "one effect of realistic size", "half": "one of half the size", "two": "two", "quiet": "nothing"}
KINDS = ("multisine", "telegraph", "steps", "prbs", "ramps", "stairs", "rate_control", "waypoints")
BEATS_HZ = (50.0, 25.0, 12.5, 10.0, 5.0)
COUPLED, MODULATING = ("ballast_flow", "mast_sway", "arm_angle"), ("voltage", "temperature", "depth")
GOOD = ("right", "class")


@dataclass(frozen=True, slots=True)
class Case:
    """One recording: the list of its effects, the kind of its torque, a key of GROUPS, and its place in the group."""

    of: str
    torque: str
    group: str
    index: int
    seed: int


def mission(case: Case, duration: float = 720.0) -> Mission:
    """What is played in a case."""
    random = np.random.default_rng([case.seed, case.index, *f"{case.of} {case.torque} {case.group}".encode()])
    effects = [*EFFECTS, *ON_CHANNEL]
    vehicles = TURNING if case.of == "main" else SECOND
    vehicle = list(vehicles.values())[int(random.integers(len(vehicles)))]
    chosen = [effects[case.index % len(effects)]] if case.group != "quiet" else []
    if case.group == "two":
        chosen.append(str(random.choice([name for name in effects if name != chosen[0]])))
    channel = {"coupling": str(random.choice(COUPLED)), "modulation": str(random.choice(MODULATING))}
    hidden = tuple(f"{name}:{channel[name]}" if name in channel else name for name in chosen)
    idle = random.permutation(CHANNELS)[: int(random.integers(0, 3))].tolist()
    beats = [hz for hz in BEATS_HZ if hz * vehicle.time >= 4.0]

    def sensing(of: Vehicle, chance: np.random.Generator) -> tuple[Sensor, ...]:
        gyro_and_compass = own_clocks(of, chance)
        return (*gyro_and_compass, torque_sensor(of, chance)) if case.torque == "measured" else gyro_and_compass

    return Mission(
        vehicle, KINDS[int(random.integers(len(KINDS)))], int(random.integers(2**31)), hidden, case.of,
        0.5 if case.group == "half" else 1.0, duration=duration, beats=float(random.choice(beats)), sensing=sensing,
        channels=tuple(dict.fromkeys([*(channel[name] for name in chosen if name in channel), *idle])),
    )  # fmt: skip


def answer(recording: Recording, inertia: float) -> Record:
    """What is named of a recording, or why nothing could be said: a refusal is an answer, a crash a result."""
    found, refused, failed = dict[str, Any](), None, None
    try:
        found = trace(runs_of([recording]), inertia=inertia).to_dict()
    except BadInput as refusal:
        refused = str(refusal)
    except Exception as error:  # the other recordings go on
        failed = f"{type(error).__name__}: {error}"
    named = {each["effect"]: list(each["cannot_tell_from"]) for each in found.get("effects", [])}
    return {"named": named, "refused": refused, "failed": failed}


def judge(hidden: Collection[str], named: Mapping[str, Collection[str]]) -> str:
    """right: the named set is the hidden one; class: what is not named is in the class of a named one, one for one;
    joint: in the class of one that is hidden itself; false: all is there and more; missed; both: missed and more."""
    wanted, found = set(hidden), set(named)
    if wanted == found:
        return "right"
    spare, missing, joint = found - wanted, 0, 0
    for effect in sorted(wanted - found):
        stand_in = next((name for name in sorted(spare) if effect in named[name]), None)
        if stand_in is not None:
            spare.discard(stand_in)
        elif any(effect in rivals for rivals in named.values()):
            joint += 1
        else:
            missing += 1
    if missing:
        return "both" if spare else "missed"
    return "false" if spare else "joint" if joint else "class"


def examine(case: Case) -> Record:
    """Plays a case, has it traced, and judges the answer."""
    outcome = play(mission(case))
    found, hidden = answer(outcome.recording, outcome.inertia), outcome.mission.hidden
    judged = next((key for key in ("failed", "refused") if found[key]), None) or judge(hidden, found["named"])
    return asdict(case) | {"kind": outcome.mission.kind, "hidden": list(hidden), **found, "judged": judged}


def report(records: Sequence[Record]) -> Iterable[str]:
    """A row for each list, torque and group; then each effect; then what is named where nothing is hidden."""
    found = [each for each in records if each["hidden"]]
    rows = [
        [of, torque, GROUPS[group], *_found(own)]
        for (of, torque, group), own in grouped(found, "of", "torque", "group").items()
    ]
    tail = ["found", "missed", "false beside", "another named", "refused", "failed"]
    yield table(["list", "torque", "hidden", *tail], rows)
    single = [each | {"effect": each["hidden"][0].partition(":")[0]} for each in found if len(each["hidden"]) == 1]
    yield table(["effect", *tail], [[name, *_found(own)] for name, own in sorted(grouped(single, "effect").items())])
    quiet = grouped([each for each in records if not each["hidden"]], "of", "torque")
    rows = [
        [of, torque, share(sum(bool(each["named"]) for each in own), len(own)),
         ", ".join(sorted({name for each in own for name in each["named"]})) or "–"]
        for (of, torque), own in quiet.items()
    ]  # fmt: skip
    yield table(["list", "torque", "false with nothing hidden", "named"], rows)


def _found(own: Sequence[Record]) -> list[object]:
    counts = Counter(each["judged"] for each in own)
    verdicts = ("missed", "false", "both", "refused", "failed")
    return [share(sum(counts[each] for each in GOOD), len(own)), *(counts[each] for each in verdicts)]


def cases(asked: argparse.Namespace) -> list[Case]:
    """The same counts of each list and each kind of torque."""
    return [
        Case(of, torque, group, index, asked.first_seed) for of in LISTS for torque in ("command", "measured")
        for group in GROUPS for index in range(getattr(asked, group))
    ]  # fmt: skip


if __name__ == "__main__":
    run(
        "trace", __doc__, cases, examine, report, first_seed=(2_400_000, "of the cases"),
        one=(36, "cases of each list and torque"), half=(18, "likewise"), two=(18, "likewise"), quiet=(36, "likewise"),
    )  # fmt: skip
