"""What goes wrong between a sensor and the bus, in messages that tests play."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from incsvr.numerics import Array
from simulator.messages import Messages, messages


def with_faults(
    streams: Mapping[str, tuple[Array, Array]],
    seed: int,
    drop_outs: float = 0.0,
    drop_out_length: float = 1.0,
    jitter: float = 0.0,
    duplicates: float = 0.0,
) -> Messages:
    """The messages of streams with faults that the seed draws.

    Args:
        drop_outs: of each stream in a minute.
        drop_out_length: their mean length [s].
        jitter: a message comes late by up to this [s], and so out of order.
        duplicates: share of the messages that are sent twice.
    """
    rng = np.random.default_rng(seed)
    whole = messages(streams)
    lost = np.zeros(len(whole), dtype=bool)
    for number, (t, _) in enumerate(streams.values()):
        for start in rng.uniform(t[0], t[-1], rng.poisson(drop_outs * (t[-1] - t[0]) / 60.0)):
            away = (whole.t >= start) & (whole.t < start + rng.exponential(drop_out_length))
            lost |= away & (whole.stream == number)
    index = np.flatnonzero(~lost)
    index = np.concatenate((index, index[rng.random(index.size) < duplicates]))
    send = whole.t[index] + rng.uniform(0.0, jitter, index.size)
    index, send = index[np.argsort(send, kind="stable")], np.sort(send, kind="stable")
    return replace(whole, stream=whole.stream[index], send=send, t=whole.t[index], value=whole.value[index])
