"""Sensors that fail: when the checks name it, and what the learner serves meanwhile and afterwards.

The pure path from streams to models: synchroniser, checks, learner, no bus. Each fault lasts ten minutes within a run
of the paper's sinusoid, without and with a heading, alone and with 2 % outliers and the hull in the middle of it.
Beside it runs a control, the same vehicle without the fault. In hours without a fault hull, drop-outs, 2 % outliers,
swell and straight driving come, and every pause is a false one.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import pairwise, product
from typing import Literal

import numpy as np

from benchmarks.study import Record, grouped, run, seeds, table
from benchmarks.voyages import CHANGES_VEHICLE, FAULTS, Voyage, day, experiment, with_drop_outs, with_outliers
from incsvr.checks import Decision, Vehicle, implausible
from incsvr.learning import checked_learner
from incsvr.learning.learner import Settings
from incsvr.signals import Synchroniser
from incsvr.signals.samples import Samples
from simulator import leng

FAULT_BEGINS_S, FAULT_LASTS_S, AFTERWARDS_S = 300.0, 600.0, 300.0
"""A fault begins within a batch after so long, lasts, and is watched afterwards [s]."""
HULL_AT_S = 450.0
"""The hull is mounted then [s], within the fault."""
LOOK_PERIOD_S = 5.0
"""The streams are taken in pieces of so long [s]."""
RATES = np.linspace(-0.22, 0.22, 45, dtype=np.float64)
"""Where the served curve is judged [rad/s]."""
ALLOWED_ERROR_RATIO, NAMED_WITHIN_S = 1.5, 60.0
"""Right: the served error is at most so many times the control's largest, and the fault is named within so long [s]."""

Policy = Literal["paper", "weighted"]
Look = tuple[float, float, bool, tuple[str, ...]]
"""A time [s], the served curve's mean error [N m], whether learning is paused, the kinds of the findings."""
Case = tuple[str, bool, bool, int, Policy, float]
"""Fault or "nothing", whether with a heading, whether with outliers and the hull, seed, policy, hours of nothing."""


def follow(voyage: Voyage, policy: Policy) -> Iterator[Look]:
    """The learner behind the checks over a voyage, looked at after each piece of it."""
    settings = Settings(policy=policy)
    vehicle = Vehicle(leng.INERTIA, settings.rate_range, leng.SIGNALS.smoothing)
    synchroniser, state, waiting = Synchroniser(leng.SIGNALS), checked_learner.begin(settings), Samples.empty()
    clocks = {name: np.fmax.accumulate(t) for name, (t, _) in voyage.streams.items()}
    began, error, paused, refused = 0.0, np.inf, False, dict[str, int]()
    while began < max(float(clock[-1]) for clock in clocks.values()):
        kinds: list[str] = []
        for name, (t, value) in voyage.streams.items():
            first, last = np.searchsorted(clocks[name], [began, began + LOOK_PERIOD_S])
            synchroniser.push(name, t[first:last], value[first:last])
            count = synchroniser.rejected_by_stream.get(name, {}).get("implausible", 0)
            if implausible(name, count - refused.get(name, 0), int(last - first), leng.SIGNALS.rate_limit):
                kinds.append("unit")
            refused[name] = count
        began += LOOK_PERIOD_S
        waiting = Samples.concatenate((waiting, synchroniser.ready()))
        while len(waiting) >= settings.batch:
            batch, waiting = waiting.take(slice(0, settings.batch)), waiting.take(slice(settings.batch, None))
            state, verdict, _ = checked_learner.learn(settings, vehicle, state, batch)
            paused = not verdict.learn
            kinds += [finding.kind for finding in verdict.findings if finding.decision > Decision.CLEAN]
            model = state.learner.model
            if model.is_trained:
                truth = voyage.damping(RATES, verdict.span[1])
                error = float(np.mean(np.abs(model.predict(RATES).damping - truth)))
        if np.isfinite(error):
            yield began, error, paused, tuple(dict.fromkeys(kinds))


def voyage_of(case: Case) -> tuple[Voyage, float, float]:
    """The voyage of a case, and when its fault begins and ends [s]."""
    fault, heading, more, seed, _, hours = case
    rng = np.random.default_rng([seed, 3])
    begins = FAULT_BEGINS_S + float(rng.uniform(0.0, 30.0))
    ends = begins + FAULT_LASTS_S
    quiet = fault == "nothing"
    voyage = day(seed, 3600.0 * hours) if quiet else experiment(
        seed, ends + AFTERWARDS_S, HULL_AT_S if more else np.inf)  # fmt: skip
    streams = {name: stream for name, stream in voyage.streams.items() if heading or name != "heading"}
    if fault in FAULTS:
        name, change = FAULTS[fault]
        t, value = streams[name]
        streams[name] = change(t, value, (t >= begins) & (t < ends), rng)
    if quiet:
        streams = with_drop_outs(streams, 0.5, rng)
    return Voyage(with_outliers(streams, 0.02, rng) if more else streams, voyage.hull), begins, ends


@cache
def control(case: Case) -> float:
    """The largest error [N m] of the same vehicle without a fault, from when one would begin."""
    voyage, begins, _ = voyage_of(case)
    return max(error for at, error, _, _ in follow(voyage, case[4]) if at > begins)


def examine(case: Case) -> Record:
    """A fault beside its control, or hours of nothing."""
    voyage, begins, ends = voyage_of(case)
    looks = list(follow(voyage, case[4]))
    about: Record = {"fault": case[0], "heading": case[1], "more": case[2], "seed": case[3], "policy": case[4]}
    if case[0] == "nothing":
        pauses = sum(look[2] and not before[2] for before, look in pairwise(looks))
        return about | {"hours": case[5], "false": pauses, "paused": float(np.mean([look[2] for look in looks])),
                        "error": float(np.mean([look[1] for look in looks]))}  # fmt: skip
    since = [look for look in looks if look[0] > begins]
    named = next((at - begins for at, _, _, kinds in since if kinds), None)
    usual = control(("none", *case[1:]))
    worst = max((error for _, error, paused, _ in since if not paused), default=0.0) / usual
    soon = named is not None and named <= NAMED_WITHIN_S
    return about | {
        "named_after": named,
        "kinds": sorted({kind for at, _, _, kinds in since if at <= ends + 30.0 for kind in kinds}),
        "paused": float(np.mean([paused for at, _, paused, _ in since if at <= ends])),
        "worst": worst,
        "at_end": looks[-1][1] / usual,
        "right": soon and (case[0] in CHANGES_VEHICLE or max(worst, looks[-1][1] / usual) <= ALLOWED_ERROR_RATIO),
    }


def cases(asked: argparse.Namespace) -> list[Case]:
    found: list[Case] = []
    for policy in ("paper", "weighted"):
        found += [(fault, heading, more, seed, policy, 0.0) for fault in FAULTS if asked.only in fault
                  for heading, more in product((False, True), repeat=2) for seed in seeds(asked)]  # fmt: skip
        found += [("nothing", bool(k % 2), True, asked.first_seed + 1000 + k, policy, asked.hours)
                  for k in range(asked.days)]  # fmt: skip
    return found


def report(results: Sequence[Record]) -> Iterator[str]:
    yield (
        f"*Right*: named within {NAMED_WITHIN_S:.0f} s, and at every look and at the end either paused or of at most "
        f"{ALLOWED_ERROR_RATIO:g} times the control's largest error over ±0.22 rad/s. *Worst* and *at the end* are "
        f"served errors over that error; {' and '.join(CHANGES_VEHICLE)} are to be named alone, and are then learned."
    )
    faults = [record for record in results if "right" in record]
    for policy, mine in grouped(faults, "policy").items():
        yield f"## Policy {policy}: {sum(record['right'] for record in mine)} of {len(mine)} right"
        rows = []
        for fault, own in grouped(mine, "fault").items():
            named = [record["named_after"] for record in own]
            rows.append([
                fault, f"{sum(record['right'] for record in own)} of {len(own)}",
                "never" if None in named else f"{np.median(named):.0f}, {max(named):.0f}",
                ", ".join(sorted({kind for record in own for kind in record["kinds"]})),
                f"{100 * np.mean([record['paused'] for record in own]):.0f} %",
                f"{max(record['worst'] for record in own):.2f}", f"{max(record['at_end'] for record in own):.2f}",
            ])  # fmt: skip
        yield table(["fault", "right", "named after s: median, most", "as", "paused", "worst", "at the end"], rows)
    hours = [[record["policy"], f"{record['hours']:g} h, seed {record['seed']}" + ", heading" * record["heading"],
              record["false"], f"{100 * record['paused']:.1f} %", f"{record['error']:.2f}"]
             for record in results if "false" in record]  # fmt: skip
    if hours:
        yield "## Hours without a fault"
        yield table(["policy", "", "false pauses", "of the time", "mean error N m"], hours)


def main(words: Sequence[str] | None = None) -> None:
    run("sensors", __doc__, cases, examine, report, words, first_seed=(795_000, "of the voyages"),
        seeds=(1, "voyages of each fault and company"), hours=(24.0, "of a day without a fault"),
        days=(2, "without a fault, for each policy"), only=("", "part of a fault's name"))  # fmt: skip


if __name__ == "__main__":
    main()
