"""Which effects a recording may lack, and from which values the search of each begins."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from incsvr.effects import Effect, Signals, Term, candidates
from incsvr.tracing.forward.equations import Part

Array = NDArray[np.float64]

OF_HEADING = ("heading_current", "tether")
"""What, beside a moment from outside, turns a vehicle whose thrusters do not: the rest only shapes a motion."""

SLIGHT = 0.02
"""Part of the size that physics allows, at which the tangent of a thrust effect is taken."""


def admissible(names: Sequence[str], signals: Signals) -> tuple[Effect, ...]:
    """The catalogue's effects for these channels; of forms that differ only where the torque is noisy, the plain one.
    Of a vehicle whose torque never changes, those that turn it without."""
    left_out = {"torque_lag/rotor speed, commanded", "torque_asymmetry/before a limit"}
    left_out |= {f"modulation:{name}/thrust, own level" for name in names}
    every = candidates(names, signals.rate_name, signals.one_clock)
    effects = tuple(effect for effect in every if effect.key not in left_out)
    if float(np.ptp(signals.torque)) > 0.0:
        return effects
    return tuple(effect for effect in effects if effect.acts == "outside" or effect.name in OF_HEADING)


def starts(effect: Effect, signals: Signals) -> Iterator[Part]:
    """The effect at every value from which it is searched; its coefficients are empty where regression finds them.

    A thrust that runs ahead of its command would look at what is not known yet: it is left out.
    """
    inner = [values for values in effect.starts(signals) if not (effect.secant and values[-1] <= 0.0)]
    if effect.acts != "thrust":
        yield from (Part(effect, Term(effect.name, effect.variant, (), values)) for values in inner)
    elif effect.fixed_coefficient:
        yield from (Part(effect, Term(effect.name, effect.variant, (1.0,), values)) for values in inner)
    elif effect.secant:  # a lag, a delay: the start is the parameter itself
        yield from (Part(effect, Term(effect.name, effect.variant, values, ())) for values in inner)
    else:
        yield from (Part(effect, Term(effect.name, effect.variant, (0.0,), values)) for values in inner)


def unit(part: Part, signals: Signals) -> float:
    """The size of a thrust effect's coefficient that changes the largest command by the whole of it."""
    if part.effect.channels:
        away = np.abs(signals.channels[part.effect.channels[0]] - part.term.inner[0])
        return 1.0 / max(float(np.quantile(away, 0.99)), 1e-12)
    if part.effect.variant == "coefficient":
        return 1.0 / max(float(np.quantile(np.abs(signals.torque), 0.99)), 1e-12)
    return 1.0


def bracket(part: Part, signals: Signals) -> tuple[float, float]:
    """Where the searched parameter is refined."""
    effect = part.effect
    if not part.thrust or effect.fixed_coefficient:
        return effect.bracket(signals, part.term.inner)
    if effect.secant:
        values = sorted({0.0, *(start[0] for start in effect.starts(signals)), 2.0 * max(0.0, part.parameter)})
        below = [v for v in values if v < part.parameter - 1e-12]
        above = [v for v in values if v > part.parameter + 1e-12]
        return (below[-1] if below else part.parameter), (above[0] if above else part.parameter)
    reach = 0.6 * unit(part, signals)
    return max(part.parameter - 0.3 * reach, -reach), min(part.parameter + 0.3 * reach, reach)
