"""The contract's parameters of an effect out of the engine's θ, and how unsure those are that are not fitted.

A row opposes its axis's effort: a moment that acts is minus its θ.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from incsvr.model.factors import one_by_one
from incsvr.model.fitting import Fit
from incsvr.model.rows import Row
from incsvr.model.series import values
from incsvr.model.structure import Theta

Values = Mapping[str, float]
"""Parameters by the contract's names."""


@dataclass(frozen=True, slots=True)
class Here:
    """What the parameters of an effect refer to.

    Attributes:
        axis: the velocity of its axis.
        of: what the engine's name has behind its colon: a channel, a product, a period, an instant.
        rows: the model's rows by their keys.
        inertia: declared [kg], [kg m²].
        begin: the stamp at which the channel `time` is zero [s].
        length: of the recordings, from their first stamp to their last [s].
        between: two neighbouring instants at which a jump was tried [s].
        power: of each row of damping by its coefficient, the mean power that it takes, by its key.
        drag_power: the same of a row r |r|.
        late: half a period of an effort that is measured, 0 of a command [s].
    """

    axis: str
    of: str
    rows: Mapping[str, Row]
    inertia: float
    begin: float
    length: float
    between: float
    power: Mapping[str, float]
    drag_power: float
    late: float

    def share(self, theta: Theta) -> float:
        """The power of a row r |r| of coefficient one in that of the damping."""
        taken = sum(theta[key] * each for key, each in self.power.items())
        return self.drag_power / max(taken, 1e-9 * self.drag_power)  # a damping that takes nothing has no share

    def width(self, name: str) -> float:
        """The width of the first factor of a row: an instant, a frequency or a mean."""
        return float(self.rows[f"{name}@{self.axis}"].parts[0].one.width)


Parameters = Callable[[Theta, Here], Values]
Unsure = Callable[[Here, Values, Values], Values]


def nothing_unsure(_here: Here, _found: Values, _half: Values) -> Values:
    return {}


def here(found: Fit, name: str, inertia: float, begin: float, late: float, instants: int = 20) -> Here:
    """What the parameters of an effect of a fit refer to.

    Args:
        name: the engine's, with its axis.
        inertia: declared.
        begin: the stamp at which the channel `time` is zero [s].
        late: half a period of an effort that is measured, 0 of a command [s].
        instants: at which `identification.pool` tries jumps.
    """
    effect, _, axis = name.partition("@")
    runs = found.problem.windows.runs
    rate = values(runs, axis)
    own = [row for row in found.structure.rows if row.name.partition(":")[0] in ("linear", "quadratic", "bend")]
    power = dict[str, float]()
    for row in own:
        if row.axis == axis:
            part = row.parts[0]
            taken = one_by_one(part.one, {axis: rate}) * one_by_one(part.other, {axis: rate})
            power[row.key] = float((taken * rate).mean())
    stamps = [run[axis][0] for run in runs]
    length = max(each[-1] for each in stamps) - min(each[0] for each in stamps)
    return Here(
        axis, effect.partition(":")[2], {row.key: row for row in found.structure.rows}, inertia, begin, float(length),
        float(length) / (instants + 1), power, float((rate * rate * abs(rate)).mean()), late,
    )  # fmt: skip


def of_row(parameter: str, name: str, sign: float = 1.0) -> Parameters:
    """One parameter that is the coefficient of a row."""
    return lambda theta, here: {parameter: sign * theta[f"{name.format(of=here.of)}@{here.axis}"]}


def of_stage(parameter: str, kind: str) -> Parameters:
    """One parameter whose logarithm is in θ."""
    return lambda theta, here: {parameter: math.exp(theta[f"{kind}:{here.axis}"])}


def inertia_values(theta: Theta, here: Here) -> Values:
    return {"inertia_kg_m2": math.exp(theta[f"mass:{here.axis}"])}


def delay_values(theta: Theta, here: Here) -> Values:
    return {"delay_s": theta[f"shift:{here.axis}"]}


def unsure_delay(here: Here, _found: Values, _half: Values) -> Values:
    """When a measured effort changes between two samples, nobody knows."""
    return {"delay_s": here.late}


def friction_values(theta: Theta, here: Here) -> Values:
    both, uneven = theta.get(f"coulomb@{here.axis}", 0.0), theta[f"coulomb_asymmetry@{here.axis}"]
    return {"moment_forward_nm": both + uneven, "moment_backward_nm": both - uneven}


def memory_values(theta: Theta, here: Here) -> Values:
    key = f"memory@{here.axis}"
    return {"gain_nm_s": -theta[key], "time_constant_s": math.exp(theta[f"time:{key}"])}


def _oscillation(sine: float, cosine: float) -> Values:
    """The moment −(s sin x + c cos x) as A sin(x + φ)."""
    return {"amplitude_nm": math.hypot(sine, cosine), "phase_rad": math.atan2(-cosine, -sine)}


def heading_values(theta: Theta, here: Here) -> Values:
    name, two = ("heading_current:2", "2") if here.of == "2" else ("heading_current", "")
    sine, cosine = (theta[f"{name}:{kind}{two}@{here.axis}"] for kind in ("sine", "cosine"))
    return {**_oscillation(sine, cosine), "harmonic": 2.0 if two else 1.0}


def wave_values(theta: Theta, here: Here) -> Values:
    name = f"wave:{here.of}:wave"
    sine, cosine = theta[f"{name}@{here.axis}"], theta[f"{name}_later@{here.axis}"]
    return {**_oscillation(sine, cosine), "period_s": 2.0 * math.pi / here.width(name)}


def unsure_wave(here: Here, found: Values, half: Values) -> Values:
    """The frequency is a line of a spectrum of four times the length; its own error is √12 relative errors of the
    amplitude in a length (D. C. Rife & R. R. Boorstyn, IEEE Trans. Inf. Theory 20, 1974)."""
    own = math.sqrt(12.0) * half["amplitude_nm"] / max(found["amplitude_nm"], 1e-300)
    frequency = math.hypot(own, math.pi / 4.0) / here.length
    return {
        "period_s": found["period_s"] ** 2 / (2.0 * math.pi) * frequency,
        "phase_rad": 0.5 * frequency * here.length,
    }


def tether_values(theta: Theta, here: Here) -> Values:
    stiffness = theta[f"tether@{here.axis}"]
    constant = theta.get(f"bias_torque@{here.axis}", 0.0)
    return {"stiffness_nm_per_rad": stiffness, "neutral_rad": -constant / stiffness if stiffness else 0.0}


def bias_drift_values(theta: Theta, here: Here) -> Values:
    return {
        "nm_per_s": -theta[f"bias_drift@{here.axis}"],
        "start_nm": -theta.get(f"bias_torque@{here.axis}", 0.0),
    }


def drag_drift_values(theta: Theta, here: Here) -> Values:
    return {"fraction": theta[f"drag_drift@{here.axis}"] * here.length * here.share(theta)}


def drag_step_values(theta: Theta, here: Here) -> Values:
    name = f"drag_step:{here.of}"
    return {"fraction": theta[f"{name}@{here.axis}"] * here.share(theta), "at_s": here.begin + here.width(name)}


def thrust_drift_values(theta: Theta, here: Here) -> Values:
    return {"fraction": -theta[f"thrust_drift@{here.axis}"] * here.length}


def thrust_step_values(theta: Theta, here: Here) -> Values:
    name = f"thrust_step:{here.of}"
    return {"fraction": -theta[f"{name}@{here.axis}"], "at_s": here.begin + here.width(name)}


def unsure_instant(here: Here, _found: Values, _half: Values) -> Values:
    return {"at_s": here.between}


def modulation_values(theta: Theta, here: Here) -> Values:
    name = f"modulation:{here.of}"
    return {"coefficient": theta[f"{name}@{here.axis}"] * here.share(theta), "reference": here.width(name)}


def thrust_speed_values(theta: Theta, here: Here) -> Values:
    name = f"thrust_speed:{here.of}"
    return {"coefficient": -theta[f"{name}@{here.axis}"], "reference": -here.width(name)}


def thrust_modulation_values(theta: Theta, here: Here) -> Values:
    name = f"modulation:{here.of}"
    return {"coefficient": -theta[f"{name}@{here.axis}"], "reference": here.width(name)}


def gyro_bias_values(theta: Theta, here: Here) -> Values:
    """The damping is about κ (c r + ½ |r| r), its slope κ (c + |r|), of which the row is θ (c + |r|)."""
    c, taken = here.width("gyro_bias"), sum(theta[key] * each for key, each in here.power.items())
    slope = taken / (c * here.power.get(f"linear@{here.axis}", 0.0) + 0.5 * here.drag_power)
    return {"rate_rad_s": -theta[f"gyro_bias@{here.axis}"] / max(slope, 1e-300)}


def coriolis_values(theta: Theta, here: Here) -> Values:
    coefficient = theta[f"coriolis:{here.of}@{here.axis}"]
    return {"coefficient": coefficient, "ratio": coefficient / here.inertia}


def square_values(theta: Theta, here: Here) -> Values:
    coefficient = theta[f"square:{here.of}@{here.axis}"]
    return {"coefficient": coefficient, "ratio": coefficient / here.inertia}
