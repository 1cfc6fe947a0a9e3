"""Two senders under one name: values, or stamps, that alternate between two series."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array
from incsvr.signals import YAW_RATE

SENDER = "(sender)"
"""The column with the number of the sender, where a log has several of one name: no field has a bracket."""
MIN_VALUES = 60
"""Values by which an alternation is seen."""
MIN_OUTSIDE = 12
"""Values of the second series at least."""
MIN_OUTSIDE_SHARE = 0.015
"""Share of the values that are of the second series at least: 2 Hz beside 50 Hz are twice as many."""
JUMP_RATIO = 5.0
"""How many times farther a value is from both neighbours than they are from each other, to be of another series."""
MIN_JUMP_SHARE = 0.1
"""How far such a value is from its neighbours at least, in parts of how far the values go."""
MAX_OWN_STEP_SHARE = 0.1
"""The usual step from one value of the second series to the next, in parts of that distance: spikes are no series."""
MAX_MIRROR_SHARE = 0.05
"""The usual step of the middle between both series, in parts of their distance: where it is less, one command goes to
and fro at every sample."""
MAX_LATE_S = 60.0
"""The time by which a message may come again [s]: what is older is of another clock."""
HALF_SHARE = 0.4
"""Share of the second series from which on it is half."""
APART_S = 1.0
"""The difference of two clocks from which on they are two [s]."""


def alternates(values: Array, is_velocity: bool = False) -> float | None:
    """The share of the second series in values (n,) in the order in which they came; None where they are one series.

    A command may go to and fro at every sample; the velocity of a body (`is_velocity`) does not.
    """
    values = values[np.isfinite(values)]
    if values.size < MIN_VALUES:
        return None
    before, at, after = values[:-2], values[1:-1], values[2:]
    jump, across = np.minimum(np.abs(at - before), np.abs(at - after)), np.abs(after - before)
    reach = float(np.quantile(np.abs(values - np.median(values)), 0.98))
    outside = (jump > JUMP_RATIO * across) & (jump > MIN_JUMP_SHARE * reach) & (reach > 0.0)
    count = int(np.count_nonzero(outside))
    if count < max(MIN_OUTSIDE, MIN_OUTSIDE_SHARE * values.size):
        return bursts_alternate(values)
    series, far = at[outside], float(np.median(jump[outside]))
    steps = np.minimum(np.abs(series[2:] - series[1:-1]), np.abs(series[2:] - series[:-2]))
    middle = 0.5 * np.abs(at + before)[outside]
    to_and_fro = not is_velocity and float(np.median(middle)) < MAX_MIRROR_SHARE * far
    if to_and_fro or float(np.median(steps)) > MAX_OWN_STEP_SHARE * far:
        return None
    return min(count / values.size, 0.5)


def bursts_alternate(
    values: Array,
    longest: int = 10,  # values that a sender sends before the other does
    covered: float = 0.3,  # of the values lie in bursts at least: noise and pulses make fewer
    regular_share: float = 0.8,  # of the bursts are as long as most, within one value, where levels tell them
    carried: float = 0.7,  # correlation of the way within a burst with that over the pauses about it
    levels: int = 4,  # changes of level amid bursts: fewer come by chance
    level_burst: int = 4,  # values of a burst that shows one: noise alone makes two levels of two or three values
) -> float | None:
    """The share of the second series in values (n,) that come in bursts of two to ten, each series in its turn.

    Pulses, limit cycles and steps come back to a value, too. Two things only senders of their own do: a slope within a
    burst carries on over the pauses about it; or a level that holds changes amid a burst, which is as long as the
    others, and has changed for the bursts to come.
    """
    values = values[np.isfinite(values)]
    reach = float(np.quantile(np.abs(values - np.median(values)), 0.98)) if values.size >= MIN_VALUES else 0.0
    edges = np.flatnonzero(np.abs(np.diff(values)) > MIN_JUMP_SHARE * reach) + 1
    if reach == 0.0 or edges.size < MIN_OUTSIDE:
        return None
    starts, ends = np.append(0, edges), np.append(edges, values.size) - 1
    length, first, last = ends - starts + 1, values[starts], values[ends]
    run = np.arange(2, starts.size - 3)

    def comes_back(over: int) -> NDArray[np.bool_]:
        """Whether the other series goes on behind so many runs."""
        before, after = last[run - 1], first[run + over]
        jump = np.minimum(np.abs(first[run] - before), np.abs(after - last[run + over - 1]))
        found: NDArray[np.bool_] = jump > JUMP_RATIO * np.abs(after - before)
        return found

    burst = np.zeros(starts.size, dtype=bool)
    burst[run] = comes_back(1) & (length[run] > 1) & (length[run] <= longest)
    at = np.flatnonzero(burst)
    if at.size < MIN_OUTSIDE or length[at].sum() < covered * values.size:
        return None
    middle, far = 0.5 * np.abs(last[at - 1] + first[at]), np.abs(first[at] - last[at - 1])
    if float(np.median(middle)) < MAX_MIRROR_SHARE * float(np.median(far)):
        return None
    usual, one = float(np.median(length[at])), at[burst[at - 1] & burst[at + 1]]
    within, about = last[one] - first[one], first[one + 2] - last[one] + first[one] - last[one - 2]
    if one.size < MIN_OUTSIDE:
        return None
    carried_on = np.count_nonzero(within * about) >= MIN_OUTSIDE and float(within @ about) > carried * float(
        np.linalg.norm(within) * np.linalg.norm(about)
    )
    steps = np.abs(np.delete(np.diff(values), edges - 1))
    noise = float(np.median(steps[steps > 0.0])) if steps.any() else 0.0
    change = np.abs(first[run + 1] - last[run])
    amid = comes_back(2) & (JUMP_RATIO * np.abs(first[run + 3] - last[run + 1]) < change)
    amid &= (
        (change > JUMP_RATIO * noise)
        & (np.abs(length[run] + length[run + 1] - usual) <= 1.0)
        & ~burst[run]
        & ~burst[run + 1]
    )
    regular = usual >= level_burst and float(np.mean(np.abs(length[at] - usual) <= 1.0)) > regular_share
    if carried_on or (regular and np.count_nonzero(amid) >= levels):
        return min(float(length[at].sum()) / values.size, 0.5)
    return None


def two_clocks(arrival: Array, stamps: Array) -> bool:
    """Whether stamps (n,) [s] come of two clocks by turns; those that come again over a second link count once."""
    first = np.sort(np.unique(stamps, return_index=True)[1])
    apart = (arrival - stamps)[first]
    apart = apart[np.isfinite(apart)]
    if apart.size < MIN_VALUES:
        return False
    changes = np.abs(np.diff(apart)) > APART_S
    back = np.abs(apart[2:] - apart[:-2]) < APART_S
    return int(np.count_nonzero(changes[1:] & changes[:-1] & back)) >= MIN_OUTSIDE


def by_turns(senders: Array, values: Array) -> float | None:
    """The share of the rarer sender in values (n,) whose senders are known by number, where they send by turns."""
    known = np.isfinite(values) & np.isfinite(senders)
    senders, values = senders[known], values[known]
    numbers, counts = np.unique(senders, return_counts=True)
    differs = (np.diff(senders) != 0.0) & (np.diff(values) != 0.0)
    if numbers.size < 2 or np.count_nonzero(differs) < MIN_OUTSIDE:
        return None
    return float(counts.min() / counts.sum())


def sentence(name: str, topic: str, share: float, known: bool = False) -> str:
    """The sentence on values that alternate; `known`: by senders that the log names."""
    if known:
        return (
            f"{name} comes by turns from two senders on {topic}, which the log names, {100.0 * share:.0f} % of it from "
            "the rarer one; let one of them be silent, or give it a name of its own, and record again"
        )
    part = "half" if share > HALF_SHARE else "a part"  # in health it must not change with every message
    return (
        f"{name} alternates between two series of values, {part} of them of the second: two senders on {topic}, or "
        "drop-outs; let one of them be silent, or give it a name of its own, and record again"
    )


@dataclass(slots=True)
class SenderWatch:
    """The newest values of each input as they came on a bus."""

    recent: dict[str, deque[float]] = field(default_factory=dict)
    last: dict[str, float] = field(default_factory=dict)

    def add(self, name: str, times: Array, values: Array) -> None:
        """More values of an input, with their times (n,) [s]; those that come again over a second link show nothing."""
        recent, last = self.recent.setdefault(name, deque(maxlen=4 * MIN_VALUES)), self.last.get(name, -np.inf)
        for time, value in zip(times.tolist(), values.tolist(), strict=True):
            if not last > time > last - MAX_LATE_S:
                last = time
                recent.append(value)
        self.last[name] = last

    def share(self, name: str) -> float | None:
        """As `alternates`, of the newest values."""
        return alternates(np.array(self.recent.get(name, ())), is_velocity=name == YAW_RATE)
