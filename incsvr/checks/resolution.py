"""The error of the learned curve because the streams are too slow for the motion.

Torque, acceleration and rate of a sample pass through the same filter, so that of Eq. 5 nothing is lost but what a mean
of d(r) differs from d of the mean rate. Where d grows with the square of the rate that makes the curve too large, most
at low rates. The textbook's N_r r + N_{r|r|} r|r| tells it: fitted to the samples with r|r| as a mean over one standard
deviation of the rate to either side, within the filter, and then asked without.

And the torque: of one on a line between two messages it is not known when it changed. By up to half of its period P it
acts earlier or later, a quarter in the mean, which makes a sample wrong by ¼ P τ̇.

Of the filter's error the mean over the samples of a rate counts, as in the regression: the few samples in which the
rate swings are wrong by most of it. The torque's is as often of either sign: of it the median, where it is no chance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.numerics import Array, robust_deviation
from incsvr.signals import SignalSettings, raw
from incsvr.signals.samples import Samples
from incsvr.signals.settings import COMMANDED, MIN_WIDTH_PERIODS

RATE_BANDS = ((0.15, 0.35), (0.35, 0.65), (0.65, 1.0))
"""Bands of the rates, in parts of the fastest, in each of which the error is told."""
MIN_ERROR_SHARE = 0.1
"""Share of the damping in a band below which an error is not said."""
AIMED_ERROR_SHARE = 0.5 * MIN_ERROR_SHARE
"""Share of the damping for which a filter that is proposed is narrow enough."""
MAX_NARROWER_SHARE = 0.9
"""Width of a narrower filter, in that of the filter, at most: less changes nothing."""
MIN_FASTEST_SHARE = 0.02
"""Share of the damping at the fastest rates below which an error is not said either: where there is next to no damping,
nobody asks for a tenth of it."""
CLEAR_STANDARD_ERRORS = 3.0
"""Standard errors by which what is said is no chance."""
MIN_SAMPLES = 5
"""Samples of a band from which anything is told."""
TAMING_ROUNDS = 5
"""Rounds in which the weights are told anew."""
FASTEST_QUANTILE = 0.98
"""Quantile of the rates that counts as the fastest: one outlier does not."""


@dataclass(frozen=True, slots=True)
class ResolutionFault:
    """The fault of motion that is too fast for the streams.

    Attributes:
        rate: where the curve may be off most, as a part of its damping [rad/s].
        share: by how much there, as a part of it.
        fastest: the fastest band's middle [rad/s].
        at_fastest: by how much there.
        late: whether most of it is that the torque comes too slowly, not that the filter is too wide.
        smoothing: the filter's width [s].
        yaw_rate_period, torque_period: between two messages [s].
    """

    rate: float
    share: float
    fastest: float
    at_fastest: float
    late: bool
    smoothing: float
    yaw_rate_period: float
    torque_period: float

    @property
    def sentence(self) -> str:
        """The sentence for people, without the cure."""
        because = (
            f"a torque every {self.torque_period:.2g} s is too seldom for this vehicle"
            if self.late
            else f"smoothing over {self.smoothing:.2g} s is too slow for this vehicle"
        )
        return (
            f"{because}: the damping curve may be "
            f"{100.0 * self.share:.0f} % wrong at {self.rate:.2g} rad/s and {100.0 * self.at_fastest:.0f} % at "
            f"{self.fastest:.2g} rad/s"
        )

    def narrower(self, settings: SignalSettings) -> float | None:
        """The width of a filter [s] that is narrow enough for the motion, or as narrow as the streams allow; None where
        they allow none that is much narrower."""
        least = MIN_WIDTH_PERIODS * self._slowest(settings)
        width = max(
            self.smoothing * (AIMED_ERROR_SHARE / self.share) ** 0.5, least
        )  # the error goes with the width squared
        return float(f"{width:.2g}") if width < MAX_NARROWER_SHARE * self.smoothing else None

    def cure(self, settings: SignalSettings) -> str:
        """The setting that helps, in the configuration's words."""
        faster = self.faster(settings)
        cure = f"send {faster}" if faster else f"set signals.smoothing to {self.narrower(settings):g}"
        if settings.torque != COMMANDED:
            cure += ", or, where the torque is a command that holds until the next, set signals.torque to commanded"
        return f"{cure}; `incsvr fit` on a log of it tries what can be set, and says what it gains"

    def faster(self, settings: SignalSettings) -> str | None:
        """The stream that is too slow and the period that it needs; None where a narrower filter will do."""
        if self.late:
            return f"the torque every {self.torque_period * MIN_ERROR_SHARE / self.share:.1g} s"
        if self.narrower(settings) is not None:
            return None
        name = "yaw rate" if self._slowest(settings) <= self.yaw_rate_period else "torque"
        wanted = self.smoothing * (AIMED_ERROR_SHARE / self.share) ** 0.5
        return f"the {name} every {wanted / MIN_WIDTH_PERIODS:.1g} s and smooth over {wanted:.1g} s"

    def _slowest(self, settings: SignalSettings) -> float:
        """Between two messages of the stream that the filter must span [s]."""
        return max(self.yaw_rate_period, 0.0 if settings.torque == COMMANDED else self.torque_period)


def resolution_fault(samples: Samples, smoothing: float) -> ResolutionFault | None:
    """The fault of streams that are too slow for the motion; None if the curve is right within 10 %.

    Args:
        samples: with what their raw streams showed.
        smoothing: the width of their filter [s].
    """
    if raw.RATE_SPREAD not in samples.raw or len(samples) < MIN_SAMPLES:
        return None
    rate, spread = samples.yaw_rate, samples.raw[raw.RATE_SPREAD]
    period = samples.raw[raw.named(raw.TORQUE, raw.PERIOD)]
    side = np.sign(rate)
    square = rate * np.abs(rate)
    blurred = 0.5 * ((rate + spread) * np.abs(rate + spread) + (rate - spread) * np.abs(rate - spread))
    linear, quadratic = _fitted(np.column_stack((rate, blurred)), samples.damping)
    curve = linear * rate + quadratic * square
    bend, late = side * quadratic * (blurred - square), 0.25 * period * side * samples.raw[raw.TORQUE_SLOPE]
    size = np.abs(rate)
    fastest = float(np.quantile(size, FASTEST_QUANTILE))
    found: list[tuple[float, float, float, bool]] = []
    largest = 0.0
    for low, high in reversed(RATE_BANDS):
        inside = (size >= low * fastest) & (size <= high * fastest) & np.isfinite(bend + late)
        if inside.sum() < MIN_SAMPLES:
            continue
        damping = float(np.mean(np.abs(curve[inside])))
        largest = max(largest, damping)
        parts = abs(float(np.mean(bend[inside]))), _clear(late[inside])
        off = sum(parts)
        counts = off > MIN_FASTEST_SHARE * largest and damping > 0.0
        found.append((float(np.mean(size[inside])), off / damping if counts else 0.0, off, parts[1] > parts[0]))
    if not found:
        return None
    worst = max(found, key=lambda each: each[1])
    if worst[1] < MIN_ERROR_SHARE:
        return None
    return ResolutionFault(
        rate=worst[0],
        share=worst[1],
        fastest=found[0][0],
        at_fastest=found[0][1],
        late=worst[3],
        smoothing=smoothing,
        yaw_rate_period=float(np.median(samples.raw[raw.named("yaw_rate", raw.PERIOD)])),
        torque_period=float(np.median(period)),
    )


def _fitted(terms: Array, damping: Array) -> tuple[float, float]:
    """Coefficients of two terms (n, 2) in a moment (n,), with little weight for what is far from most."""
    weight = np.ones(damping.size)
    for _ in range(TAMING_ROUNDS):
        root = np.sqrt(weight)
        best = np.linalg.lstsq(terms * root[:, None], damping * root)[0]
        left = np.abs(damping - terms @ best)
        weight = 1.0 / np.maximum(left, max(float(np.median(left)), 1e-300))
    return float(best[0]), float(best[1])


def _clear(values: Array) -> float:
    """The size of the median of (n,) values, as far as it is no chance."""
    median = float(np.median(values))
    doubt = 1.25 * robust_deviation(values - median) / np.sqrt(values.size)
    return abs(median) if abs(median) > CLEAR_STANDARD_ERRORS * doubt else 0.0
