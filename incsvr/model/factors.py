"""The factors of a model's rows, evaluated together: a few array operations, however many rows there are."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from incsvr.model.rows import Factor
from incsvr.numerics import Array

SIMPLE: dict[str, Callable[[Array], Array]] = {
    "size": np.abs, "square": np.square, "root": lambda x: np.sqrt(np.abs(x)), "sine": np.sin, "cosine": np.cos,
    "drag": lambda x: x * np.abs(x), "sine2": lambda x: np.sin(2.0 * x), "cosine2": lambda x: np.cos(2.0 * x),
}  # fmt: skip
"""Kinds of factors that are a function of their signal alone."""
BY_WIDTH: dict[str, Callable[[Array, float], Array]] = {
    "sign": lambda x, width: np.tanh(x / width),
    "after": lambda x, width: (x >= width).astype(np.float64),
}
"""Kinds of factors that depend on their width besides."""


class Factors:
    """The factors of some rows in one array: 1, all signals as they are, then functions of signals.

    Args:
        factors: to be evaluated.
        signals: names of all signals, in their order.
    """

    def __init__(self, factors: Sequence[Factor], signals: Sequence[str]) -> None:
        place = {name: k for k, name in enumerate(signals)}
        self._signals = len(signals)
        self.place: dict[Factor, int] = {Factor("one"): 0}
        self.place |= {Factor("value", name): k + 1 for name, k in place.items()}
        self._simple: list[tuple[Callable[[Array], Array], Array, slice]] = []
        self._by_width: list[tuple[Callable[[Array, float], Array], int, float, int]] = []
        self._down: list[tuple[str, int]] = []
        count = len(signals) + 1
        for kind, function in SIMPLE.items():
            own = list(dict.fromkeys(each for each in factors if each.kind == kind))
            if own:
                self._simple.append(
                    (function, np.array([place[each.of] for each in own]), slice(count, count + len(own)))
                )
                self.place |= {each: count + k for k, each in enumerate(own)}
                count += len(own)
        for each in dict.fromkeys(factors):
            if each.kind in BY_WIDTH:
                self._by_width.append((BY_WIDTH[each.kind], place[each.of], each.width, count))
            elif each.kind.startswith("down"):
                self._down.append((each.kind, count))
            else:
                continue
            self.place[each] = count
            count += 1
        self._angles = (place.get("roll"), place.get("pitch"))
        self.count = count

    def __call__(self, signals: Array, out: Array) -> Array:
        """(…, factors, windows) from (…, signals, windows), written to `out`, whose first factor is 1 already."""
        out[..., 1 : self._signals + 1, :] = signals
        for function, of, several in self._simple:
            out[..., several, :] = function(signals[..., of, :])
        for by_width, which, width, to in self._by_width:
            out[..., to, :] = by_width(signals[..., which, :], width)
        if self._down:
            roll, pitch = (signals[..., place, :] for place in self._angles)
            for kind, to in self._down:
                out[..., to, :] = _down(kind, roll, pitch)
        return out


def one_by_one(factor: Factor, signals: Mapping[str, Array]) -> Array:
    """One factor of signals by name, in the shape of the signals."""
    if factor.kind == "one":
        return np.ones_like(next(iter(signals.values())))
    if factor.kind == "value":
        return signals[factor.of]
    if factor.kind in BY_WIDTH:
        return BY_WIDTH[factor.kind](signals[factor.of], factor.width)
    if factor.kind.startswith("down"):
        return _down(factor.kind, signals["roll"], signals["pitch"])
    return SIMPLE[factor.kind](signals[factor.of])


def _down(kind: str, roll: Array, pitch: Array) -> Array:
    """A part of the downward direction in the body's frame (Fossen 2011, Eq. 2.18)."""
    if kind == "down_x":
        return np.asarray(-np.sin(pitch))
    return np.asarray(np.cos(pitch) * (np.sin(roll) if kind == "down_y" else np.cos(roll)))
