"""Live tracing on ordinary missions of an hour, and on the demo's third act: what is found, when, and what falsely.

`make live-missions`. In half of the missions an effect comes on at an instant that the seed draws, in the other half
nothing but noise, water and ordinary work happens. The learner adopts what it proves. A seed names a mission.
"""

from __future__ import annotations

import time
import traceback
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from benchmarks.study import Record, begin, in_processes, options, publish, revision
from benchmarks.tables import grouped, page, table
from benchmarks.tracer.live_watch import Watched, watch
from incsvr.compensation.fresh_data import as_run
from incsvr.errors import BadInput
from incsvr.tracing import trace
from service.commands import demo_underway
from service.commands.config_output import scaled_config
from service.config.configuration import Config
from service.config.sources import read
from service.recordings.recording import Streams, sequence
from service.recordings.recording_csv import RATE_LIMIT
from service.recordings.samples_from_recording import learner_for, samples_of, signals_for
from simulator import leng, underway
from simulator.missions import Mission, play

EFFECTS = ("dead_zone", "torque_asymmetry", "torque_saturation", "bias_torque", "inertia", "torque_lag", "torque_delay")
KINDS = ("survey", "transit", "waypoints", "zigzag", "circles", "pipeline", "day", "station")
VEHICLES = ("auv", "rov", "leng")
HOUR_S, MIN_ONSET_S, MAX_ONSET_S = 3600.0, 1200.0, 2400.0
"""Length of a mission, and the earliest and latest onset of an effect [s]."""
IN_TIME_S = 600.0
"""Right within ten minutes of data after the onset."""
EARLIER_SEED_OFFSET = 500_000
"""Between the seeds of a mission and of the earlier dive of its kind on which the configuration is scaled, as
`incsvr fit --write` does it: its first minutes alone would call every sharper turn after them implausible."""


def drawn(seed: int, hidden: bool) -> Mission:
    """The mission that a seed draws; with and without an effect it is the same in everything else."""
    random = np.random.default_rng([seed, *b"live"])
    kind, vehicle, effect = (str(random.choice(names)) for names in (KINDS, VEHICLES, EFFECTS))
    onset = float(round(random.uniform(MIN_ONSET_S, MAX_ONSET_S)))
    if not hidden:
        return Mission(kind, vehicle, seed, duration=HOUR_S)
    return Mission(kind, vehicle, seed, effect, onset=onset, duration=HOUR_S)


def configured(mission: Mission, mode: str) -> Config:
    """What an operator has who scaled the configuration on an earlier dive of the same kind."""
    scaled = _scaled(Mission(mission.kind, mission.vehicle, mission.seed + EARLIER_SEED_OFFSET, duration=HOUR_S))
    return scaled.model_copy(update={"tracing": scaled.tracing.model_copy(update={"live": mode})})


@lru_cache(maxsize=1)
def _scaled(earlier: Mission) -> Config:
    """The configuration that an earlier dive gives."""
    played = play(earlier)
    signals = signals_for([played.recording], played.inertia, RATE_LIMIT)
    samples, _ = samples_of(played.recording, signals, None)
    base = read(None, {"state": None, "tracing": {"live": "adopt", "window": 600.0, "proof": 60.0}})
    return scaled_config(base, played.recording, signals, learner_for(samples, policy="paper"))


def examine(case: tuple[str, int]) -> Record:
    """Plays one case; a crash is a result too."""
    group, seed = case
    began = time.perf_counter()
    try:
        record = _act(seed) if group == "act" else _mission(seed, group == "hidden")
    except Exception as error:  # the other cases go on, and the table says which failed
        where = traceback.format_exc(limit=-3)
        record = {"failed": f"{type(error).__name__}: {error}", "where": where}
    return {"group": group, "seed": seed, "seconds": round(time.perf_counter() - began, 1)} | record


def _mission(seed: int, hidden: bool) -> Record:
    mission = drawn(seed, hidden)
    outcome = play(mission)
    seen = watch(configured(mission, "adopt"), outcome.recording)
    about = {"kind": mission.kind, "vehicle": mission.vehicle, "effect": mission.effect, "onset": mission.onset}
    record: Record = about | _steps(seen)
    if hidden:
        record |= _judged(seen, str(mission.effect), mission.onset, "promoted")
        record["alone"] = _alone(mission, outcome.recording.streams(), outcome.inertia)
        twin = play(drawn(seed, False))
        knew = watch(configured(mission, "off"), twin.recording)
        served = seen.error(HOUR_S - IN_TIME_S)
        record["error"] = {"served": served if np.isfinite(served) else None, "sound": knew.error(HOUR_S - IN_TIME_S)}
    return record


def between(streams: Streams, begins: float, ends: float) -> Streams:
    """What came from one time to another [s]; a stream that has nothing there is left out."""
    return {name: (t[here], v[here]) for name, (t, v) in streams.items() if (here := (t >= begins) & (t < ends)).any()}


def _alone(mission: Mission, streams: Streams, inertia: float) -> bool | None:
    """Whether a trace of the ten minutes after the onset, and of nothing else, names what came on, or has it in its
    class: what the data hold, whatever is made of them live. None where the tracer refuses them."""
    ten = between(streams, mission.onset, mission.onset + IN_TIME_S)
    try:
        found = trace([as_run(ten)], inertia=inertia)
    except BadInput:
        return None
    return any(mission.effect in (each.effect, *each.cannot_tell_from) for each in found.effects)


def _act(seed: int) -> Record:
    """The demo's third act after its experiment, with the demo's settings."""
    act = underway.play(seed)
    whole = sequence([leng.recording("T1", 1), leng.recording("T2", 1), act.recording])
    begins = float(whole.time[-1] - act.recording.time[-1])
    words = dict(setting.split("=") for setting in demo_underway.SETTINGS)
    settings = {name.partition(".")[2]: value for name, value in words.items()}
    seen = watch(read(None, {"state": None, "tracing": settings}), whole)
    record: Record = {"kind": "act", "vehicle": "leng", "effect": act.effect, "onset": begins + act.onset}
    return record | _steps(seen) | _judged(seen, act.effect, begins + act.onset, "proven")


def _steps(seen: Watched) -> Record:
    kept = ("suspected", "proven", "promoted", "refused", "withdrawn", "failed")
    steps = [(step["t"], step["step"], step["effect"]) for step in seen.history if step["step"] in kept]
    return {"steps": steps, "failures": [step["why"] for step in seen.history if step["step"] == "failed"]}


def _judged(seen: Watched, effect: str, onset: float, step: str) -> Record:
    """When what was hidden, or one that the finding says it cannot tell from it, came this far; and what else did."""
    classes: dict[str, set[str]] = {}
    contents = (seen.state.active, seen.state.proven, seen.state.suspect)
    for content in contents:
        for finding in () if content is None else content.effects:
            classes[str(finding["effect"])] = {*finding.get("cannot_tell_from", ())}
    named = [(each["t"], str(each["effect"])) for each in seen.history if each["step"] == step and each["t"] > onset]
    right = [t for t, name in named if name == effect or effect in classes.get(name, ())]
    wrong = sorted({name for t, name in named if name != effect and effect not in classes.get(name, ())})
    before = [each["effect"] for each in seen.history if each["step"] == step and each["t"] <= onset]
    return {"after": min(right) - onset if right else None, "wrong": wrong, "before_onset": before}


def report(document: Record) -> str:
    """Markdown."""
    records: Sequence[Record] = document["records"]
    groups = grouped([record for record in records if "failed" not in record], "group")
    return page(
        "# Live tracing on missions of an hour",
        f"Made by `{document['command']}` on {document['date']}, revision {document['revision']}, in "
        f"{document['minutes']} minutes; {document['asked'] - len(records)} of {document['asked']} cases were not run "
        "for want of time. The process beside the learner is run in place: its answer comes before the next batch.",
        *(_effect_comes(groups["hidden"]) if "hidden" in groups else ()),
        *(_nothing_hidden(groups["quiet"]) if "quiet" in groups else ()),
        *(_third_act(groups["act"]) if "act" in groups else ()),
        *(f"Failed: {each['group']} {each['seed']}: {each['failed']}" for each in records if "failed" in each),
    )


def _effect_comes(hidden: Sequence[Record]) -> tuple[str, ...]:
    in_time = sum(each["after"] is not None and each["after"] <= IN_TIME_S for each in hidden)
    return (
        "## An effect comes on",
        f"Promoted right within {IN_TIME_S:g} s of data after the onset: {in_time} of {len(hidden)}; within the "
        f"hour: {sum(each['after'] is not None for each in hidden)}. Something else promoted after the onset: "
        f"{sum(bool(each['wrong']) for each in hidden)}; anything before it: "
        f"{sum(bool(each['before_onset']) for each in hidden)}. A trace of the ten minutes "
        "after the onset by themselves names it, or has it in its class, in "
        f"{sum(bool(each['alone']) for each in hidden)} of {len(hidden)} (column *alone*; – where they hold too "
        "little motion to be traced): more cannot be found in time. Served ÷ sound: the torque's "
        "error over the last ten minutes, over that of the same mission in which nothing came on.",
        _rows(hidden),
    )


def _nothing_hidden(quiet: Sequence[Record]) -> tuple[str, ...]:
    steps = [[step for _, step, _ in each["steps"]] for each in quiet]
    return (
        "## Nothing hidden",
        f"Hours with a promotion: {sum('promoted' in each for each in steps)} of {len(quiet)}; findings suspected in "
        f"them: {sum(each.count('suspected') for each in steps)}.",
        _rows(quiet),
    )


def _third_act(act: Sequence[Record]) -> tuple[str, ...]:
    suspected = sum(
        any(s == "suspected" and name == each["effect"] and t > each["onset"] for t, s, name in each["steps"])
        for each in act
    )
    return (
        "## The demo's third act",
        f"Proven right: {sum(each['after'] is not None for each in act)} of {len(act)}; right and at least suspected: "
        f"{suspected}; something else proven: {sum(bool(each['wrong']) for each in act)}.",
        _rows(act),
    )


def _rows(records: Sequence[Record]) -> str:
    head = ["seed", "mission", "vehicle", "hidden", "onset s", "alone", "right after s", "else", "suspicions"]
    rows = []
    for each in sorted(records, key=lambda one: one["seed"]):
        error, after = each.get("error"), each.get("after")
        ratio = "–" if error is None else "paused"
        if error is not None and error["served"] is not None:
            ratio = f"{error['served'] / error['sound']:.2f}"
        came = [name for _, step, name in each["steps"] if step in ("promoted", "proven")]
        rows.append([
            each["seed"],
            each["kind"],
            each["vehicle"],
            each["effect"] or "–",
            f"{each['onset']:.0f}" if each["effect"] else "–",
            {True: "yes", False: "no", None: "–"}[each.get("alone")],
            "–" if after is None else f"{after:.0f}",
            ", ".join(each.get("wrong", sorted(set(came)))) or "–",
            sum(step == "suspected" for _, step, _ in each["steps"]),
            ratio,
        ])  # fmt: skip
    return table([*head, "served ÷ sound"], rows)


def main(words: Sequence[str] | None = None) -> None:
    parser = options(
        "benchmarks.tracer.live_missions",
        __doc__,
        first_seed=(930_000, "of the missions"),
        hidden=(40, "missions in which an effect comes on"),
        quiet=(40, "missions in which nothing does"),
        acts=(20, "third acts of the demo"),
        minutes=(float("inf"), "after which no case is begun"),
        processes=(2, "cases at once"),
    )
    args, measured = begin(parser, words)
    counts = {"hidden": args.hidden, "quiet": args.quiet, "act": args.acts}
    cases = [
        (group, args.first_seed + 1000 * number + k)
        for k in range(max(counts.values(), default=0))
        for number, (group, count) in enumerate(counts.items())
        if k < count
    ]
    commit, began = revision(), time.perf_counter()
    records = in_processes(examine, cases, "cases", args.processes, args.minutes)
    document = measured | {
        "records": records,
        "revision": commit,
        "minutes": round((time.perf_counter() - began) / 60.0, 1),
        "asked": len(cases),
    }
    publish(args.out, "live_missions", document, report(document))


if __name__ == "__main__":
    main()
