"""The share of recorded motion that is evidence about damping, and the water's motion in the rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.learning.driven_motion import WINDOW_SAMPLES
from incsvr.learning.noise import Mask
from incsvr.numerics import independent_share
from incsvr.signals.samples import Samples

ANSWERING_T = 3.0
"""Student's t from which on the torque answers the rate, over all motion that the water makes: by chance one in 700."""
LITTLE_EVIDENCE_SHARE = 0.05
"""Share of the samples that is evidence below which somebody should know."""
HORIZON_SAMPLES = 1000.0
"""Samples that the running means of the water stand for, at most."""


@dataclass(frozen=True, slots=True)
class Water:
    """The motion that was no evidence: running means over all samples, to which driven samples add nothing."""

    rate: float = 0.0  # mean r² of it [rad²/s²]
    moment: float = 0.0  # mean y² of it [N² m²]: of about the water's own moment
    share: float = 0.0  # of the samples, in 0 to 1
    seen: float = 0.0  # samples that the means stand for

    def after(self, batch: Samples, driven: Mask) -> Water:
        """The means after a batch of n ≥ 1 samples."""
        n, rate, moment, count = len(batch), 0.0, 0.0, 0.0
        if not driven.all():
            rate, moment = float((batch.yaw_rate**2) @ ~driven), float((batch.damping**2) @ ~driven)
            count = float(np.count_nonzero(~driven))
        known = min(self.seen, max(HORIZON_SAMPLES - n, 0.0))
        seen = known + n
        return Water(
            (known * self.rate + rate) / seen,
            (known * self.moment + moment) / seen,
            (known * self.share + count) / seen,
            seen,
        )


@dataclass(frozen=True, slots=True)
class Excitation:
    """The share of some samples that is evidence about damping."""

    driven: int  # samples whose motion the torque made
    samples: int  # of all
    fastest: float  # largest |r| among all [rad/s]
    # lowest and highest rate of the driven ones [rad/s]; None where there is none
    driven_rates: tuple[float, float] | None

    @staticmethod
    def of(batch: Samples, undriven: Samples) -> Excitation:
        """The excitation of a batch of n ≥ 1 samples, some of them undriven."""
        rates = batch.yaw_rate[~np.isin(batch.time, undriven.time)]
        driven_rates = (float(rates.min()), float(rates.max())) if rates.size else None
        return Excitation(rates.size, len(batch), float(np.abs(batch.yaw_rate).max()), driven_rates)

    @staticmethod
    def together(parts: Sequence[Excitation]) -> Excitation:
        """The excitation of several batches, at least one."""
        rates = [part.driven_rates for part in parts if part.driven_rates is not None]
        return Excitation(
            sum(part.driven for part in parts),
            sum(part.samples for part in parts),
            max(part.fastest for part in parts),
            (min(low for low, _ in rates), max(high for _, high in rates)) if rates else None,
        )

    @property
    def sentence(self) -> str:
        """The sentence on the excitation, with its figures."""
        if self.driven_rates is None:
            return f"the torque caused none of the motion of {self.samples} samples, up to {self.fastest:.3g} rad/s"
        low, high = self.driven_rates
        return (
            f"the torque caused the motion of {self.driven} of {self.samples} samples "
            f"({100.0 * self.driven / self.samples:.2g} %), at {low:.3g} to {high:.3g} rad/s"
        )

    @property
    def little(self) -> bool:
        """Whether so few samples are evidence that somebody should know."""
        return self.driven < LITTLE_EVIDENCE_SHARE * self.samples


EXCITING_MANOEUVRE = (
    "drive steps of torque to both sides, from weak to full, each held until the yaw rate has settled, for some minutes"
)
"""Manoeuvre that would be evidence."""


def torque_answers(undriven: Samples) -> bool:
    """Whether a controller has closed the loop: where the water makes the motion, y is −K r then, and nothing else is.

    In open loop, where ṙ is as often positive as negative at every rate, y averages to the torque, which does not know
    the rate. Motion that the torque makes throughout tells nothing of the kind: then this says no.
    """
    r, y = undriven.yaw_rate, undriven.damping
    motion, work = float(r @ r), float(r @ y)
    if r.size < WINDOW_SAMPLES or not motion > 0.0:
        return False
    left = y - work / motion * r
    return work < 0.0 and r.size * independent_share(left) * work * work > ANSWERING_T**2 * motion * float(left @ left)
