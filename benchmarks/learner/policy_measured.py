"""Both policies on the BlueROV's recordings, with the settings that `incsvr fit` gives them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

import numpy as np

from benchmarks.learner.policies import POLICIES, Policy, scaled
from benchmarks.study import MEASURED, Record
from incsvr.learning.model import Model
from incsvr.signals import synchronise
from incsvr.signals.samples import Samples
from service.recordings.recording import Recording, sequence
from service.recordings.recording_csv import read
from service.recordings.samples_from_recording import Errors, learn, signals_for

FOLDER = MEASURED / "bluerov"
OPEN_LOOP, CLOSED_LOOP = (3, 4, 5), tuple(range(7, 16))
"""Runs whose yaw is driven."""
INERTIAS = (0.6, 1.125)
"""What a least squares on these runs prefers, and what was published [kg m²]."""
RATE_LIMIT = 6.0


class Runs:
    """The recordings with a declared inertia [kg m²]."""

    def __init__(self, inertia: float) -> None:
        self.inertia = inertia

    @cached_property
    def recordings(self) -> Mapping[int, Recording]:
        return {number: read(FOLDER / f"run_{number:02d}.csv") for number in OPEN_LOOP + CLOSED_LOOP}

    def samples(self, numbers: Sequence[int], group: Sequence[int]) -> Samples:
        """Those of some runs, with the signal settings of a group of runs."""
        signals = signals_for([self.recordings[number] for number in group], self.inertia, RATE_LIMIT)
        return synchronise(signals, sequence([self.recordings[number] for number in numbers]).streams())[0]

    def progressive(self, numbers: Sequence[int], group: Sequence[int], policy: Policy) -> tuple[float, Model]:
        """The mean error on batches before they are learned [N m], and the last model."""
        stream = self.samples(numbers, group)
        iterations = list(learn(stream, scaled(stream, policy)))
        errors = [iteration.progressive_mae for iteration in iterations if iteration.progressive_mae is not None]
        return float(np.mean(errors)), iterations[-1].model

    def on_the_way(self, numbers: Sequence[int], unseen: int, policy: Policy) -> list[float]:
        """The error on an unseen run after each iteration [N m]."""
        stream, judge = self.samples(numbers, numbers), self.samples([unseen], numbers)
        return [Errors.of(iteration.model, judge).mae for iteration in learn(stream, scaled(stream, policy))]


def rows(inertia: float) -> Iterator[Record]:
    """Each figure with a value a run under each policy."""
    runs, where = Runs(inertia), f"BlueROV, I = {inertia:g} kg m²"

    def row(name: str, figure: str, values: Mapping[Policy, Sequence[float]]) -> Record:
        return {"name": f"{where}: {name}", "figure": figure, "kind": "run"} | {each: values[each] for each in POLICIES}

    for what, group in (("open loop, runs 03–05", OPEN_LOOP), ("closed loop, runs 07–15", CLOSED_LOOP)):
        ahead: dict[Policy, list[float]] = {policy: [] for policy in POLICIES}
        unseen: dict[Policy, list[float]] = {policy: [] for policy in POLICIES}
        for left_out in group:
            for policy in POLICIES:
                error, model = runs.progressive([each for each in group if each != left_out], group, policy)
                ahead[policy].append(error)
                unseen[policy].append(Errors.of(model, runs.samples([left_out], group)).mae)
        yield row(what, "MAE on each run left out [N m]", unseen)
        yield row(what, "progressive MAE without it [N m]", ahead)
    way = {policy: runs.on_the_way((3, 4), 5, policy) for policy in POLICIES}
    for figure, first in (("MAE on run 05 at the end [N m]", -1), ("MAE on run 05, mean over the iterations [N m]", 0)):
        values = {policy: [float(np.mean(way[policy][first:]))] for policy in POLICIES}
        yield row("learned from runs 03 and 04", figure, values)
    both = OPEN_LOOP + CLOSED_LOOP
    results = {policy: runs.progressive(both, both, policy) for policy in POLICIES}
    yield row("both days in order", "progressive MAE [N m]", {each: [results[each][0]] for each in POLICIES})
    back = {
        policy: [Errors.of(results[policy][1], runs.samples([number], both)).mae for number in OPEN_LOOP]
        for policy in POLICIES
    }
    yield row("the first day's runs asked again at the end", "MAE [N m]", back)
