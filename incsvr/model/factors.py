"""The factors of a model's rows, evaluated together: a few array operations, however many rows there are."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from incsvr.model.rows import ONE, Factor
from incsvr.numerics import Array

Indices = NDArray[np.intp]

SIMPLE: dict[str, Callable[[Array], Array]] = {
    "size": np.abs, "square": np.square, "root": lambda x: np.sqrt(np.abs(x)), "sine": np.sin, "cosine": np.cos,
    "drag": lambda x: x * np.abs(x), "sine2": lambda x: np.sin(2.0 * x), "cosine2": lambda x: np.cos(2.0 * x),
    "signum": np.sign, "root_slope": lambda x: 0.5 * np.sign(x) / np.sqrt(np.maximum(np.abs(x), 1e-9)),
}  # fmt: skip
"""Kinds of factors that are a function of their signal alone."""
BY_WIDTH: dict[str, Callable[[Array, float], Array]] = {
    "sign": lambda x, width: np.tanh(x / width),
    "sign_slope": lambda x, width: (1.0 - np.tanh(x / width) ** 2) / width,
    "after": lambda x, width: (x >= width).astype(np.float64),
}
"""Kinds of factors that depend on their width besides."""
SLOPES = {
    "value": (1.0, "one"), "size": (1.0, "signum"), "square": (2.0, "value"), "root": (1.0, "root_slope"),
    "sine": (1.0, "cosine"), "cosine": (-1.0, "sine"), "sine2": (2.0, "cosine2"), "cosine2": (-2.0, "sine2"),
    "drag": (2.0, "size"), "sign": (1.0, "sign_slope"),
}  # fmt: skip
"""The slope of a kind of factor by its signal, as a number times a kind of factor."""
SLOPES_OF_DOWN = {
    "down_x": ((-1.0, Factor("cosine", "pitch"), "pitch"),),
    "down_y": ((1.0, Factor("down_z"), "roll"), (1.0, Factor("down_y_pitch"), "pitch")),
    "down_z": ((-1.0, Factor("down_y"), "roll"), (1.0, Factor("down_z_pitch"), "pitch")),
}
"""The slopes of a part of the downward direction: a number, a factor, and the angle."""


def slopes(factor: Factor) -> tuple[tuple[float, Factor, str], ...]:
    """The slopes of a factor by each signal on which it depends: a number, a factor, and the signal's name."""
    if factor.kind in SLOPES_OF_DOWN:
        return SLOPES_OF_DOWN[factor.kind]
    if factor.kind not in SLOPES:
        return ()
    number, kind = SLOPES[factor.kind]
    return ((number, ONE if kind == "one" else Factor(kind, factor.of, factor.width), factor.of),)


class Factors:
    """The factors of some rows in one array (factors, …): 1, all signals as they are, then functions of signals.

    Args:
        factors: to be evaluated.
        signals: names of all signals, in their order.
    """

    def __init__(self, factors: Iterable[Factor], signals: Sequence[str]) -> None:
        at = {name: k + 1 for k, name in enumerate(signals)}
        self.place: dict[Factor, int] = {ONE: 0} | {Factor("value", name): k for name, k in at.items()}
        self._functions: list[tuple[Callable[[Array], Array], slice | Indices, slice]] = []
        self._down: list[tuple[str, int]] = []
        new = [each for each in dict.fromkeys(factors) if each not in self.place]
        count = len(signals) + 1
        for kind, function in SIMPLE.items():
            own = [each for each in new if each.kind == kind]
            if own:
                of = np.array([at[each.of] for each in own])
                even = slice(int(of[0]), int(of[-1]) + 1) if np.all(np.diff(of) == 1) else of  # a slice copies nothing
                self._functions.append((function, even, slice(count, count + len(own))))
                self.place |= {each: count + k for k, each in enumerate(own)}
                count += len(own)
        for each in new:
            if each.kind in BY_WIDTH:
                by_width = partial(_by_width, BY_WIDTH[each.kind], each.width)
                self._functions.append((by_width, slice(at[each.of], at[each.of] + 1), slice(count, count + 1)))
            elif each.kind.startswith("down"):
                self._down.append((each.kind, count))
            else:
                continue
            self.place[each] = count
            count += 1
        self._angles = (at.get("roll"), at.get("pitch"))
        self.count = count

    def fill(self, values: Array) -> None:
        """Writes the functions into (…, factors, windows), which has 1 and the signals already."""
        for function, of, to in self._functions:
            values[..., to, :] = function(values[..., of, :])
        if self._down:
            roll, pitch = (values[..., place, :] for place in self._angles)
            for kind, at in self._down:
                values[..., at, :] = _down(kind, roll, pitch)


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


def _by_width(function: Callable[[Array, float], Array], width: float, x: Array) -> Array:
    return function(x, width)


def _down(kind: str, roll: Array, pitch: Array) -> Array:
    """A part of the downward direction in the body's frame (Fossen 2011, Eq. 2.18), or its slope by pitch."""
    if kind == "down_x":
        return np.asarray(-np.sin(pitch))
    across = np.sin(roll) if kind.startswith("down_y") else np.cos(roll)
    return np.asarray((-np.sin(pitch) if kind.endswith("pitch") else np.cos(pitch)) * across)
