"""The factors of a model's rows, evaluated together: a few array operations, however many rows there are."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from incsvr.model.rows import ONE, Factor
from incsvr.numerics import Array

Indices = NDArray[np.intp]

Function = Callable[..., Array]
"""A function of an array of signals; a second array, where it is given, takes the values."""
SIMPLE: dict[str, Function] = {
    "size": np.abs, "square": np.square, "sine": np.sin, "cosine": np.cos, "signum": np.sign,
    "root": lambda x, out=None: np.sqrt(np.abs(x), out),
    "drag": lambda x, out=None: np.multiply(x, np.abs(x), out),
    "sine2": lambda x, out=None: np.sin(2.0 * x, out),
    "cosine2": lambda x, out=None: np.cos(2.0 * x, out),
    "root_slope": lambda x, out=None: np.divide(0.5 * np.sign(x), np.sqrt(np.maximum(np.abs(x), 1e-9)), out),
}  # fmt: skip
"""Kinds of factors that are a function of their signal alone."""
BY_WIDTH: dict[str, Function] = {
    "sign": lambda width, x, out=None: np.tanh(x / width, out),
    "sign_slope": lambda width, x, out=None: np.divide(1.0 - np.tanh(x / width) ** 2, width, out),
    "wave": lambda width, x, out=None: np.sin(width * x, out),
    "wave_later": lambda width, x, out=None: np.cos(width * x, out),
    "about": lambda width, x, out=None: np.subtract(x, width, out),
    "raised": lambda width, x, out=None: np.add(np.abs(x), width, out),
    "bend": lambda width, x, out=None: np.subtract(x, np.minimum(np.maximum(x, -width), width), out),
    "beyond": lambda width, x, out=None: np.multiply(np.abs(x) > width, 1.0, out),
    "after": lambda width, x, out=None: np.multiply(x >= width, 1.0, out),
}
"""Kinds of factors that depend on their width besides, which comes first."""
SLOPES = {
    "value": (1.0, "one"), "size": (1.0, "signum"), "square": (2.0, "value"), "root": (1.0, "root_slope"),
    "sine": (1.0, "cosine"), "cosine": (-1.0, "sine"), "sine2": (2.0, "cosine2"), "cosine2": (-2.0, "sine2"),
    "drag": (2.0, "size"), "sign": (1.0, "sign_slope"), "about": (1.0, "one"),
    "raised": (1.0, "signum"), "bend": (1.0, "beyond"),
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
    if factor.kind == "curve":
        rise = tuple(np.gradient(np.array(factor.table), factor.width).tolist())
        return ((1.0, replace(factor, table=rise), factor.of),)
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
        self._functions: list[tuple[Function, slice | Indices, slice]] = []
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
                by_width = partial(BY_WIDTH[each.kind], each.width)
                self._functions.append((by_width, slice(at[each.of], at[each.of] + 1), slice(count, count + 1)))
            elif each.kind == "curve":
                by_table = _on_curve(each.table, each.width)
                self._functions.append((by_table, slice(at[each.of], at[each.of] + 1), slice(count, count + 1)))
            elif each.kind.startswith("down"):
                self._down.append((each.kind, count))
            else:
                continue
            self.place[each] = count
            count += 1
        self._angles = (at.get("roll"), at.get("pitch"))
        self.count = count

    def into(self, values: Array) -> list[Callable[[], object]]:
        """What writes the functions into (…, factors, windows), which has 1 and the signals already."""
        found: list[Callable[[], object]] = []
        for function, of, to in self._functions:
            if isinstance(of, slice):
                found.append(partial(function, values[..., of, :], values[..., to, :]))
            else:
                found.append(partial(_gathered, function, values, of, values[..., to, :]))
        if self._down:
            roll, pitch = (values[..., place, :] for place in self._angles)
            found += [partial(_down, kind, roll, pitch, values[..., at, :]) for kind, at in self._down]
        return found


def one_by_one(factor: Factor, signals: Mapping[str, Array]) -> Array:
    """One factor of signals by name, in the shape of the signals."""
    if factor.kind == "one":
        return np.ones_like(next(iter(signals.values())))
    if factor.kind == "value":
        return signals[factor.of]
    if factor.kind in BY_WIDTH:
        return BY_WIDTH[factor.kind](factor.width, signals[factor.of])
    if factor.kind == "curve":
        return _on_curve(factor.table, factor.width)(signals[factor.of])
    if factor.kind.startswith("down"):
        return _down(factor.kind, signals["roll"], signals["pitch"])
    return SIMPLE[factor.kind](signals[factor.of])


def _gathered(function: Function, values: Array, of: Indices, out: Array) -> Array:
    return function(values[..., of, :], out)


def _on_curve(table: Sequence[float], width: float) -> Function:
    """A table's lines between its values, the last of which go on beyond it."""
    values, ends = np.array(table), 1e9 * width * np.array([-1.0, 1.0])
    at = width * (np.arange(values.size) - 0.5 * (values.size - 1))
    beyond = [values[k] + (end - at[k]) / width * rise
              for k, end, rise in zip((0, -1), ends, np.diff(values)[[0, -1]], strict=True)]  # fmt: skip
    at, values = np.r_[ends[0], at, ends[1]], np.r_[beyond[0], values, beyond[1]]
    return lambda x, out=None: np.add(np.interp(x, at, values), 0.0, out)


def _down(kind: str, roll: Array, pitch: Array, out: Array | None = None) -> Array:
    """A part of the downward direction in the body's frame (Fossen 2011, Eq. 2.18), or its slope by pitch."""
    if kind == "down_x":
        return np.asarray(np.negative(np.sin(pitch), out))
    across = np.sin(roll) if kind.startswith("down_y") else np.cos(roll)
    return np.asarray(np.multiply(-np.sin(pitch) if kind.endswith("pitch") else np.cos(pitch), across, out))
