"""The words of a quantity in a dive, and of its change: since when, by how much, and how sure."""

from __future__ import annotations

import math

from incsvr.learning.coefficients import NORMAL_95_DEVIATIONS
from incsvr.vehicle.compare import Value


def value_line(dive: str, value: Value) -> str:
    """A dive's value with its interval, beside that of the dives before."""
    against = "" if value.reference is None else f"  before {value.reference:.4g}, p = {value.p_value:.2g}"
    mark = "  CHANGED" if value.changed else ""
    return f"  {dive:<24}{value.estimate:>10.4g} ({value.low:.4g} to {value.high:.4g}){against}{mark}"


def change_words(value: Value) -> str:
    """By how much a value changed against the dives before, with an interval of 95 %, and how sure that is."""
    before, before_error = value.reference or 0.0, value.reference_error or 0.0
    certainty = f"p = {value.p_value:.1g}"
    if not before or value.estimate / before <= 0.0:
        return f"changed from {before:.4g} to {value.estimate:.4g} from this dive on ({certainty})"
    ratio = value.estimate / before
    spread = math.hypot(value.error / value.estimate, before_error / before)
    ends = (ratio * math.exp(side * NORMAL_95_DEVIATIONS * spread) for side in (0.0, -1.0, 1.0))
    by, low, high = (f"{100.0 * (each - 1.0):+.0f}" for each in ends)
    return f"changed by {by} % from this dive on (95 %: {low} to {high} %; {certainty})"
