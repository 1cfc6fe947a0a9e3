"""What the learner behind its checks makes of a voyage: named when, paused how long, served how well.

The pure path from streams to models: synchroniser → checks → learner, no bus. Each fault lasts ten minutes within a run
of the paper's sinusoid; then the sensor is sound again. Beside it runs a control, the same vehicle without the fault.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cache
from itertools import pairwise

import numpy as np

from benchmarks.learner import sensor_scenarios as scenarios
from benchmarks.learner.policies import Policy, batches
from benchmarks.study import Record
from incsvr.checks import Decision, Vehicle, implausible
from incsvr.learning import checked_learner
from incsvr.learning.learner import Settings
from incsvr.numerics import Array
from incsvr.signals import Synchroniser
from incsvr.signals.samples import Samples
from simulator import leng

FAULT_BEGINS_S, FAULT_LASTS_S, AFTERWARDS_S = 300.0, 600.0, 300.0
"""A fault begins within a batch after so long, lasts, and is watched afterwards [s]."""
LOOK_PERIOD_S = 5.0
"""The streams are taken in pieces of so long [s]."""
RATES: Array = np.linspace(-0.22, 0.22, 45)
"""Where the served curve is judged [rad/s]."""
ALLOWED_ERROR_RATIO = 1.5
"""The served error may be so many times the control's."""
NAMED_WITHIN_S = 60.0
"""Longest time until a fault is named that counts as right [s]."""
HULL_AT_S = 450.0
"""In the combinations the hull is mounted then [s], within the fault."""


@dataclass(frozen=True, slots=True)
class Look:
    """What is served and said at a time [s]: the curve's mean error [N m], whether it is paused, the kinds said."""

    at: float
    error: float
    paused: bool
    kinds: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Case:
    """A fault, or none, and what comes with it."""

    fault: str
    heading: bool
    more: bool  # 2 % outliers and the hull
    seed: int


def follow(voyage: scenarios.Voyage, settings: Settings) -> Iterator[Look]:
    """The learner behind the checks over a voyage, looked at after each piece of it."""
    vehicle = Vehicle(leng.INERTIA, settings.rate_range, leng.SIGNALS.smoothing)
    synchroniser, state, waiting = Synchroniser(leng.SIGNALS), checked_learner.begin(settings), Samples.empty()
    clocks = {name: np.fmax.accumulate(t) for name, (t, _) in voyage.streams.items()}
    began, paused = 0.0, False
    refused: dict[str, int] = {}
    error = np.inf
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
            if not model.is_trained:
                continue
            truth = (1.0 + voyage.hull(verdict.span[1])) * leng.damping(RATES)
            error = float(np.mean(np.abs(model.predict(RATES).damping - truth)))
        if np.isfinite(error):
            yield Look(began, error, paused, tuple(dict.fromkeys(kinds)))


def sailed(case: Case) -> tuple[scenarios.Voyage, float, float]:
    """The voyage of a case, and when its fault begins and ends [s]."""
    rng = np.random.default_rng([case.seed, 3])
    begins = FAULT_BEGINS_S + float(rng.uniform(0.0, 30.0))
    ends = begins + FAULT_LASTS_S
    voyage = scenarios.experiment(case.seed, ends + AFTERWARDS_S, HULL_AT_S if case.more else np.inf)
    streams = dict(voyage.streams)
    if not case.heading:
        del streams["heading"]
    fault = scenarios.FAULTS.get(case.fault, scenarios.NO_FAULT)
    streams = fault.on(streams, begins, ends, rng)
    if case.more:
        streams = scenarios.with_outliers(streams, 0.02, rng)
    return scenarios.Voyage(streams, voyage.hull), begins, ends


@cache
def control(heading: bool, more: bool, seed: int, policy: Policy) -> float:
    """The largest error [N m] of the same vehicle without a fault, from when one would begin."""
    voyage, begins, _ = sailed(Case("none", heading, more, seed))
    return float(np.max([look.error for look in follow(voyage, Settings(policy=policy)) if look.at > begins]))


def judged(case: Case, policy: Policy) -> Record:
    """A case beside its control."""
    voyage, begins, ends = sailed(case)
    looks = list(follow(voyage, Settings(policy=policy)))
    usual = control(case.heading, case.more, case.seed, policy)
    since = [look for look in looks if look.at > begins]
    named = next((look for look in since if look.kinds), None)
    served = [look.error for look in since if not look.paused]
    at_end = [look for look in looks if look.at > ends + AFTERWARDS_S - 60.0]
    record = asdict(case) | {
        "policy": policy,
        "named_after": None if named is None else named.at - begins,
        "kinds": sorted({kind for look in since if look.at <= ends + 30.0 for kind in look.kinds}),
        "paused": float(np.mean([look.paused for look in since if look.at <= ends])),
        "early": sorted({kind for look in looks if look.at <= begins for kind in look.kinds}),
        "control": usual,
        "worst_while_learning": max(served, default=0.0) / usual,
        "at_end": at_end[-1].error / usual if at_end else None,
        "paused_at_end": bool(at_end and at_end[-1].paused),
    }
    return record | {"right": right(record)}


def right(record: Record) -> bool:
    """Named soon; while it learned, and at the end, as good as the control; a changed vehicle is to be named alone."""
    soon = record["named_after"] is not None and record["named_after"] <= NAMED_WITHIN_S
    if scenarios.FAULTS[record["fault"]].changes_vehicle:
        return soon
    return (
        soon
        and record["worst_while_learning"] <= ALLOWED_ERROR_RATIO
        and (record["at_end"] or np.inf) <= ALLOWED_ERROR_RATIO
    )


def quiet(day: tuple[int, float, bool], policy: Policy) -> Record:
    """Hours without a sensor's fault: hull, drop-outs, 2 % outliers, swell, straight driving.

    Args:
        day: its seed, how many hours it has, and whether a heading is recorded.
    """
    seed, hours, heading = day
    began = time.process_time()
    voyage = scenarios.day(seed, 3600.0 * hours)
    rng = np.random.default_rng([seed, 4])
    streams = scenarios.with_outliers(scenarios.with_drop_outs(voyage.streams, 0.5, rng), 0.02, rng)
    if not heading:
        del streams["heading"]
    looks = list(follow(scenarios.Voyage(streams, voyage.hull), Settings(policy=policy)))
    pauses = [look for before, look in pairwise(looks) if look.paused and not before.paused]
    return {
        "policy": policy,
        "seed": seed,
        "heading": heading,
        "hours": hours,
        "false_pauses": len(pauses),
        "at": [[look.at, *look.kinds] for look in pauses],
        "paused": float(np.mean([look.paused for look in looks])),
        "said": {
            kind: sum(kind in look.kinds for look in looks) for kind in sorted({k for x in looks for k in x.kinds})
        },
        "error": float(np.mean([look.error for look in looks])),
        "processor_s": time.process_time() - began,
    }


def paper(seed: int, policy: Policy) -> Record:
    """The paper's experiment: T1 without the hull, T2 with it."""
    settings = Settings(policy=policy)
    vehicle = Vehicle(leng.INERTIA, settings.rate_range, leng.SIGNALS.smoothing)
    experiment, state = leng.experiment(seed), checked_learner.begin(settings)
    paused, said = 0, set()
    for samples in (experiment.T1, experiment.T2):
        for batch in batches(samples, settings.batch):
            state, verdict, _ = checked_learner.learn(settings, vehicle, state, batch)
            paused += not verdict.learn
            said |= {finding.kind for finding in verdict.findings}
    return {"policy": policy, "seed": seed, "paused_batches": paused, "said": sorted(said)}
