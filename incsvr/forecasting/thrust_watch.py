"""Is thrust lost, or back? Told within a minute, from errors of prediction one command ahead.

Over a cell between two commands I ṙ + d(r) = τ, with d(r) linear and quadratic, predicts the yaw rate by a
Rosenbrock–Euler step. What it is off by, as a moment u [N m], follows from what of the equation is otherwise,

    u = −f τ − g d(r) + b + Σ lₖ (τ₋ₖ − τ₋₂ₖ) + a |τ| + c τ|τ| + Σ eⱼ hⱼ(r) + noise,

f is thrust that is lacking, g damping that has grown, b a moment; beside them l is what comes late of the thrust, a its
asymmetry, c its curve, and e an error of d(r) about a rate. The noise is the water's and the gyro's. What usually acts,
(1 − f) τ + Σ l … + a |τ| + c τ|τ|, is the thrust that can be lost: rotors may lag, and I may be declared wrong.
Whitened, the errors are innovations, and a torque that answers the rate does no harm (Forssell and Ljung, Automatica
35, 1999). For each instant of the last minute and a half as an onset, data before it say within what all of these lie,
and data after it weigh, by their marginal likelihood,

    nothing, against a change of f alone, of g alone, of b alone, or of the inertia alone (f = h, g = −h).

By how much f wanders between stretches of earlier data of the same length counts as usual. Thrust has changed where f
explains what came far better than nothing does, and clearly better than the others do.
Source of the test: A. Willsky, H. Jones, IEEE Trans. Automatic Control 21, 1976 (generalised likelihood ratio).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from incsvr.forecasting.command_cells import CommandCells
from incsvr.forecasting.prediction_noise import START, fitted_noise, whiten
from incsvr.forecasting.thrust_evidence import CHANGES, CURVE_KNOTS, MIN_DRIFTS, ThrustEvidence, drift_of_thrust, sums
from incsvr.numerics import Array

MEMORY_S = 600.0
"""The time for which cells are kept [s]: what is usual is told from them."""
WATCH_PERIOD_S, ONSET_PERIOD_S = 10.0, 5.0
"""Time of the vehicle between two looks, and between two onsets that are tried [s]."""
NOISE_PERIOD_S = 60.0
"""Time for which a noise that was fitted stands [s]."""
MIN_ONSET_AGE_S, MAX_ONSET_AGE_S = 20.0, 90.0
"""How long ago an onset is looked for [s]: a single turn tells little of how large a change is."""
MIN_REFERENCE_S, MIN_REFERENCE_AFTER_S = 120.0, 30.0
"""Time of the data before an onset, at least, and the same after an earlier change [s]."""
LAGS_CELLS, MIN_LAG_S = (1, 2, 4, 8, 16), 0.1
"""Ages up to which what the command was before may still act, in cells; of shorter cells as many count as one as last
MIN_LAG_S [s]."""
THRUST_CAUSES = slice(3, 5 + len(LAGS_CELLS))
"""Columns of the causes that say what thrust is made of a command: its lags, its asymmetry and its curve."""
MIN_CELLS = 20
"""Cells before an onset, and after it, at least."""
MIN_LOG_ODDS = 10.0
"""Logarithm of the Bayes factor from which on thrust has changed, and nothing has not."""
MIN_LEADS = {"damping": 3.0, "moment": 3.0, "inertia": 1.0}
"""The same beside each other change. An inertia does not change at an instant, unless something is dropped."""
CLEAR_LEAD = 3.0
"""The same from which on the data tell the other change apart."""
MIN_CHANGE, MIN_CHANGE_DEVIATIONS = 0.1, 4.0
"""Part of the thrust that is a fault, and by how many of its deviations it must differ from none."""
BACK_LEVEL = 0.9
"""Part of the thrust from which on it is back."""
MIN_DRIVEN_SHARE = 0.5
"""Part of the usual torque (root mean square) that the data after an onset must have: on a leg where a controller only
answers the water, whatever is late in the loop looks like thrust that is lacking."""
MAX_STILL_SHARE = 0.5
"""Share of the cells after an onset in which the yaw rate may stand still to the bit."""
NORMAL_95_DEVIATIONS = 1.959964
"""Half an interval of 95 % in standard deviations."""


@dataclass(frozen=True, slots=True)
class ThrustState:
    """What is remembered from look to look.

    Attributes:
        level: part of the usual thrust that there is, 1 where all is.
        since: the last change [s]; data from before it do not count. −∞ before one.
        noise: of the errors (`prediction_noise.START`).
        fitted: when it was fitted [s].
    """

    level: float = 1.0
    since: float = -np.inf
    noise: tuple[float, ...] = START
    fitted: float = -np.inf


@dataclass(frozen=True, slots=True)
class ThrustChange:
    """Thrust that was lost, or that came back.

    Attributes:
        since: its onset [s].
        seen: the end of the data that show it [s].
        level: part of the usual thrust that there is from then on, and its deviation.
        log_odds: logarithm of the Bayes factor against no change.
        leads: the same against each other change.
    """

    since: float
    seen: float
    level: tuple[float, float]
    log_odds: float
    leads: Mapping[str, float]

    @property
    def cannot_tell_from(self) -> tuple[str, ...]:
        """Other changes that the data do not tell apart from this one."""
        return tuple(name for name, lead in self.leads.items() if lead < CLEAR_LEAD)

    @property
    def is_back(self) -> bool:
        """Whether the thrust is what it was before anything was lost."""
        return self.level[0] >= BACK_LEVEL


def look(state: ThrustState, cells: CommandCells, inertia: float) -> tuple[ThrustState, ThrustChange | None]:
    """What the newest MEMORY_S of cells say, given what was known at the last look; `inertia` is I [kg m²]."""
    damping, slope = _drag(cells, inertia)
    counted = cells.end > state.since
    cells, damping, slope = cells.take(counted), damping[counted], slope[counted]
    if len(cells) < 2 * MIN_CELLS:
        return state, None
    error, causes = _errors(cells, damping, slope, inertia)
    newest = float(cells.end[-1])
    least = MIN_REFERENCE_AFTER_S if np.isfinite(state.since) else MIN_REFERENCE_S
    tried = newest - np.arange(MAX_ONSET_AGE_S, MIN_ONSET_AGE_S - 1.0, -ONSET_PERIOD_S)
    first = np.searchsorted(cells.end, tried[tried >= cells.end[0] + least])
    onsets = np.unique(first[(first >= MIN_CELLS) & (first <= len(cells) - MIN_CELLS)])
    if not onsets.size or not np.std(cells.torque[: onsets[0]]) > 0.0:
        return state, None
    noise = np.array(state.noise)
    if not 0.0 <= newest - state.fitted < NOISE_PERIOD_S:
        noise = fitted_noise(error[: onsets[0]], causes[: onsets[0]], noise)
        state = replace(state, noise=tuple(noise.tolist()), fitted=newest)
    white = whiten(noise, np.column_stack((error, causes)))
    change = _judged(white[:, 0], white[:, 1:], onsets, cells)
    if change is None:
        return state, None
    gain, doubt = 1.0 - change.level[0], change.level[1]
    level = state.level * (1.0 - gain)
    found = replace(change, level=(level, state.level * doubt))
    if state.level >= BACK_LEVEL and found.is_back:
        return state, None  # thrust that grew was never lost
    return replace(state, level=1.0 if found.is_back else level, since=change.since), found


def _drag(cells: CommandCells, inertia: float) -> tuple[Array, Array]:
    """(n,) d(r) [N m] and its slope [N m s/rad] where cells begin: the best l r + q r|r| with l, q ≥ 0 of these cells
    themselves. A learned curve finds no more, as the causes hold what this one errs by."""
    rate, size = cells.first, np.abs(cells.first)
    moment = cells.torque - inertia * (cells.last - cells.first) / cells.length
    both = np.linalg.lstsq(np.column_stack((rate, rate * size)), moment, rcond=None)[0]
    linear, quadratic = np.maximum(both, 0.0).tolist()
    return linear * rate + quadratic * rate * size, linear + 2.0 * quadratic * size


def _errors(cells: CommandCells, damping: Array, slope: Array, inertia: float) -> tuple[Array, Array]:
    """(n,) errors of prediction as moments [N m], and (n, p) what each cause makes of them."""
    slope = np.maximum(slope, 1e-9)
    gain = -np.expm1(-slope * cells.length / inertia) / slope
    error = (cells.last - cells.first) / gain - cells.torque + damping
    torque, size = cells.torque, np.abs(cells.torque)
    several = max(round(MIN_LAG_S / float(np.median(cells.length))), 1)
    lags = [min(several * lag, torque.size) for lag in LAGS_CELLS]
    late = [np.concatenate((np.full(lag, torque[0]), torque[:-lag])) for lag in lags]
    steps = [now - before for now, before in pairwise((torque, *late))]
    known = (-torque, -damping, np.ones(len(cells)), *steps, size, size * torque)
    return error, np.column_stack((*known, _near_knots(cells.first)))


def _near_knots(rate: Array) -> Array:
    """(n, CURVE_KNOTS) how near (n,) rates are to each of the knots among them: 1 at it, and 0 from the next one on."""
    low, high = float(rate.min()), float(rate.max())
    place = (rate - low) / max(high - low, 1e-12) * (CURVE_KNOTS - 1)
    return np.maximum(1.0 - np.abs(place[:, None] - np.arange(CURVE_KNOTS)), 0.0)


def _judged(white: Array, causes: Array, onsets: NDArray[np.intp], cells: CommandCells) -> ThrustChange | None:
    """The change of thrust that explains the innovations far better than nothing and than any other change."""
    before = slice(0, onsets[0])
    usual = np.linalg.lstsq(causes[before], white[before], rcond=None)[0]
    variance = float(np.mean((white[before] - causes[before] @ usual) ** 2))
    # What is lost of the thrust is lost of what usually acts of its command, with its gain, lag and curve.
    acting = (1.0 - usual[0]) * causes[:, 0] - causes[:, THRUST_CAUSES] @ usual[THRUST_CAUSES]
    causes = np.column_stack((acting, causes[:, 1:]))
    scale = np.maximum(np.sqrt(np.mean(causes[before] ** 2, axis=0)), 1e-12)
    causes = causes / scale
    loud = float(np.sqrt(np.mean(cells.torque[before] ** 2)))
    units = scale * np.array([1.0, 1.0, loud, *(1.0,) * len(LAGS_CELLS), 1.0, 1.0 / loud, *(loud,) * CURVE_KNOTS])
    total = np.cumsum(sums(white, causes, (0, *onsets.tolist(), white.size)), axis=0)
    known, fresh, count = total[:-1], total[-1] - total[:-1], white.size - onsets

    def weighed(drift: float) -> ThrustEvidence:
        return ThrustEvidence.of(
            known / variance, fresh / variance, count, units, (max(drift, MIN_DRIFTS[0]), *MIN_DRIFTS[1:])
        )

    seen = weighed(0.0)
    # Louder water is no evidence: the variance is at least what the change of thrust leaves over.
    variance *= max(float(seen.left[int(np.argmax(seen.changed[:, 0]))]), 1.0)
    seen = weighed(0.0)
    best = int(np.argmax(seen.changed[:, 0]))
    if best == onsets.size - 1:
        return None  # the onset may be later than any that is tried yet
    # A vehicle with an effect that the model lacks wanders more than MIN_DRIFTS: its own earlier stretches say how far.
    seen = weighed(drift_of_thrust(white[before], causes[before], white.size - int(onsets[best]), units, variance))
    found = seen.changed[best, 0]
    odds = float(found - np.max(seen.nothing))
    leads = {name: float(found - np.max(seen.changed[:, CHANGES.index(name)])) for name in MIN_LEADS}
    share, doubt = 1.0 - float(seen.more[best]), float(seen.doubt[best])
    if odds < MIN_LOG_ODDS or any(lead < MIN_LEADS[other] for other, lead in leads.items()):
        return None
    if abs(1.0 - share) < max(MIN_CHANGE, MIN_CHANGE_DEVIATIONS * doubt) or share < -2.0 * doubt:
        return None
    if np.sqrt(np.mean(cells.torque[onsets[best] :] ** 2)) < MIN_DRIVEN_SHARE * loud:
        return None
    if np.mean(cells.last[onsets[best] :] == cells.first[onsets[best] :]) > MAX_STILL_SHARE:
        return None  # a gyro that is stuck shows no motion either
    since = float(cells.end[onsets[best]] - cells.length[onsets[best]])
    return ThrustChange(since, float(cells.end[-1]), (share, doubt), odds, leads)
