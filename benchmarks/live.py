"""Live tracing in missions of an hour: when an effect that comes on is named, and what is named in quiet hours.

The learner is configured from an earlier dive of the same kind, as `incsvr fit --write` does it, and puts in force what
it proves. The process beside the learner runs in its place, so that its answer comes before the next batch.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.live_watch import Watched, watch
from benchmarks.study import Record, grouped, run, share, table
from service.config.configuration import Config
from service.config.sources import read
from service.fitting.scaled import scaled_config
from service.recordings.reading import RATE_LIMIT
from service.recordings.samples_from_recording import learner_for, samples_of, signals_for
from simulator.mission import Mission
from simulator.vehicles import TURNING
from simulator.world import Outcome, play_together

EFFECTS = ("dead_zone", "torque_asymmetry", "torque_saturation", "bias_torque", "inertia", "torque_lag", "torque_delay")
KINDS = ("survey", "transit", "waypoints", "zigzag", "circles", "pipeline", "station")
VEHICLES = ("auv", "rov", "leng")
IN_TIME_S = 600.0
"""Right within ten minutes of data after the onset."""
STEPS = ("suspected", "proven", "promoted", "refused", "withdrawn", "failed")


@dataclass(frozen=True, slots=True)
class Case:
    """A mission: its seed, whether an effect comes on, and its length [s]."""

    seed: int
    hidden: bool
    duration: float


def drawn(case: Case) -> Mission:
    """The mission of a case; with and without an effect it is the same in everything else."""
    random = np.random.default_rng([case.seed, *b"live"])
    kind, vehicle, effect = (str(random.choice(names)) for names in (KINDS, VEHICLES, EFFECTS))
    onset = float(round(random.uniform(1.0 / 3.0, 2.0 / 3.0) * case.duration))
    hidden = (effect,) if case.hidden else ()
    return Mission(TURNING[vehicle], kind, case.seed, hidden, onset=onset, duration=case.duration)


def configured(earlier: Outcome) -> Config:
    """What an operator has who scaled the configuration on an earlier dive."""
    signals = signals_for([earlier.recording], earlier.inertia, RATE_LIMIT)
    samples, _ = samples_of(earlier.recording, signals, None)
    base = read(None, {"state": None, "tracing": {"live": "adopt", "window": 600.0, "proof": 60.0}})
    return scaled_config(base, earlier.recording, signals, learner_for(samples))


def examine(case: Case) -> Record:
    """Plays one case beside the earlier dive; a crash is a result too."""
    mission = drawn(case)
    before = Mission(mission.vehicle, mission.kind, mission.seed + 500_000, duration=case.duration)
    earlier, outcome = play_together([before, mission])
    about: Record = {
        "seed": case.seed, "hours": case.duration / 3600.0, "kind": mission.kind, "onset": mission.onset,
        "vehicle": next(name for name, each in TURNING.items() if each is mission.vehicle),
        "effect": mission.hidden[0] if mission.hidden else None,
    }  # fmt: skip
    try:
        seen = watch(configured(earlier), outcome.recording)
    except Exception as error:  # the other cases go on, and the table says which failed
        return about | {"failed": f"{type(error).__name__}: {error}"}
    steps = [[each["t"], each["step"], each["effect"]] for each in seen.history if each["step"] in STEPS]
    return about | {"steps": steps} | judged(seen, mission)


def judged(seen: Watched, mission: Mission) -> Record:
    """When what came on, or one that the finding cannot tell from it, was promoted; and what else was."""
    classes: dict[str, set[str]] = {}
    for content in (seen.state.active, seen.state.proven, seen.state.suspect):
        for finding in () if content is None else content.effects:
            classes[str(finding["effect"])] = {*finding.get("cannot_tell_from", ())}
    promoted = [(each["t"], str(each["effect"])) for each in seen.history if each["step"] == "promoted"]
    right = [
        t - mission.onset for t, name in promoted
        if t > mission.onset and {name, *classes.get(name, ())} & set(mission.hidden)
    ]  # fmt: skip
    wrong = sorted({
        name for t, name in promoted if t <= mission.onset or not {name, *classes.get(name, ())} & set(mission.hidden)
    })  # fmt: skip
    return {"after": min(right) if right else None, "wrong": wrong}


def report(records: Sequence[Record]) -> Iterable[str]:
    """What came on and when it was promoted; then the quiet hours."""
    ran = [each for each in records if "failed" not in each]
    hidden, quiet = [each for each in ran if each["effect"]], [each for each in ran if not each["effect"]]
    in_time = sum(each["after"] is not None and each["after"] <= IN_TIME_S for each in hidden)
    yield (
        f"An effect comes on: promoted right within {IN_TIME_S:g} s of data in {share(in_time, len(hidden))}, before "
        f"the end in {sum(each['after'] is not None for each in hidden)}; something else in "
        f"{sum(bool(each['wrong']) for each in hidden)}."
    )
    yield (
        f"Nothing comes on: {sum(each['hours'] for each in quiet):g} hours, of which with a promotion "
        f"{share(sum(bool(each['wrong']) for each in quiet), len(quiet))}; suspicions: "
        f"{sum(step == 'suspected' for each in quiet for _, step, _ in each['steps'])}."
    )
    rows = [
        [each["seed"], each["kind"], each["vehicle"], each["effect"] or "–",
         f"{each['onset']:.0f}" if each["effect"] else "–",
         "–" if each["after"] is None else f"{each['after']:.0f}", ", ".join(each["wrong"]) or "–",
         sum(step == "suspected" for _, step, _ in each["steps"])]
        for own in grouped(ran, "effect").values() for each in own
    ]  # fmt: skip
    yield table(["seed", "mission", "vehicle", "comes on", "at s", "right after s", "else", "suspicions"], rows)
    yield "\n".join(f"Failed: {each['seed']}: {each['failed']}" for each in records if "failed" in each)


def cases(asked: argparse.Namespace) -> list[Case]:
    """The missions in which an effect comes on, then those in which none does."""
    length = 60.0 * asked.minutes
    loud = [Case(asked.first_seed + k, True, length) for k in range(asked.hidden)]
    return loud + [Case(asked.first_seed + 1000 + k, False, length) for k in range(asked.quiet)]


if __name__ == "__main__":
    run(
        "live", __doc__, cases, examine, report, first_seed=(2_600_000, "of the missions"),
        hidden=(40, "missions in which an effect comes on"), quiet=(40, "missions in which none does"),
        minutes=(60.0, "length of a mission"),
    )  # fmt: skip
