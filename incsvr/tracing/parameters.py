"""The contract's parameters of the effects of a fit, each with its interval of 95 %."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from incsvr.model.fitting import Fit
from incsvr.model.intervals import covariance, reach, widened
from incsvr.numerics import Array
from incsvr.tracing.effect_values import Here, Parameters, here
from incsvr.tracing.vocabulary import word_of

POSITIVE = ("time_constant_s", "half_width_nm", "limit_nm", "reverse_efficiency", "exponent", "inertia_kg_m2")
"""Parameters that are fitted as their logarithms; so are the ends of their intervals."""


def parameters_of(
    found: Fit, effects: Sequence[str], inertia: float, begin: float, others: Sequence[Fit] = (), late: float = 0.0
) -> list[tuple[dict[str, float], dict[str, tuple[float, float]]]]:
    """For each effect its parameters, and the ends of their intervals.

    Args:
        found: the fit that estimates them.
        effects: the engine's names, with their axis.
        inertia: declared.
        begin: the stamp at which the channel `time` is zero [s].
        others: fits of the same effects; what they move beyond an interval widens it.
        late: half a period of an effort that is measured, 0 of a command [s].
    """
    spreads = [covariance(each) for each in (found, *others)]
    result = []
    for name in effects:
        word, at = word_of(name), here(found, name, inertia, begin, late)
        parameters = dict(word.parameters(found.theta, at))
        half, *rest = (
            _half_widths(each, word.parameters, at, spread)
            for each, spread in zip((found, *others), spreads, strict=True)
        )
        moved = [word.parameters(each.theta, at) for each in others]
        for key, width in half.items():
            moves = [
                (abs(_difference(key, one[key], parameters[key])), own[key])
                for one, own in zip(moved, rest, strict=True)
            ]
            half[key] = widened(width, moves)
        for key, more in word.unsure(at, parameters, half).items():
            half[key] = math.hypot(half[key], more)
        result.append((parameters, {key: ends(key, value, half[key]) for key, value in parameters.items()}))
    return result


def ends(name: str, value: float, half: float) -> tuple[float, float]:
    """The ends of an interval, of what is positive by nature in its logarithm."""
    if name in POSITIVE and value > 0.0:
        factor = math.exp(min(half / value, 700.0))
        return value / factor, value * factor
    return value - half, value + half


def has_size(
    spans: Mapping[str, tuple[float, float]],
    inertia: float,
    period: float,
    band: float,
    most: float = 10.0,
    least: float = 0.03,  # of the declared inertia or thrust, which nobody knows better
) -> bool:
    """Whether the interval of an effect's first parameter excludes that nothing acts.

    Args:
        inertia: declared.
        period: of the velocity's samples [s], within which no delay is known.
        band: the half width that a dead band has at least [N], [N m].
        most: how far the ends of what is positive by nature may be apart, as a factor, to be a size.
        least: by how much an inertia or a thrust differs from the declared one at least, as a share.
    """
    name, (low, high) = next(iter(spans.items()))
    if name == "delay_s":
        return low > period or high < -period
    if name == "half_width_nm":
        return band < math.sqrt(low * high) and high < most * low  # the middle of its logarithms
    if name == "inertia_kg_m2":
        return high < (1.0 - least) * inertia or low > (1.0 + least) * inertia
    if name in ("reverse_efficiency", "exponent"):
        return high < 1.0 - least or low > 1.0 + least
    return high < most * low if name in POSITIVE else not low <= 0.0 <= high


def _half_widths(found: Fit, parameters: Parameters, at: Here, spread: Array) -> dict[str, float]:
    """By parameter, half the width of its interval."""
    slopes = _slopes(found, parameters, at, spread)
    return {key: reach(found) * math.sqrt(max(float(slope @ spread @ slope), 0.0)) for key, slope in slopes.items()}


def _slopes(found: Fit, parameters: Parameters, at: Here, spread: Array) -> Mapping[str, Array]:
    """(p,) by parameter, its derivatives by θ, over a hundredth of each deviation."""
    slopes = dict[str, Array]()
    for place, name in enumerate(found.names):
        nudge = 0.01 * math.sqrt(max(float(spread[place, place]), 0.0))
        if nudge == 0.0:
            continue
        up, down = (parameters({**found.theta, name: found.theta[name] + way * nudge}, at) for way in (1.0, -1.0))
        for key in up:
            slopes.setdefault(key, np.zeros(len(found.names)))[place] = _difference(key, up[key], down[key]) / (
                2.0 * nudge
            )
    return slopes


def _difference(name: str, one: float, other: float) -> float:
    """One less another, of angles the short way round."""
    away = one - other
    return math.remainder(away, 2.0 * math.pi) if name == "phase_rad" else away
