"""What was learned of one axis: figures with intervals, the curve, and a vehicle with that axis alone.

The textbook's form is d(r) = N_r r + N_{r|r|} r|r|, positive where damping opposes the motion, in
I ṙ + d(r) = τ. Tools that count hydrodynamic derivatives (Fossen, SNAME) have both with the other sign.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.coefficients import COEFFICIENT_NAMES, Interval, coefficients, negative_drag
from incsvr.numerics import Array, root_mean_square
from incsvr.plant.axes import AXES, YAW
from incsvr.plant.terms import BIAS, LINEAR, QUADRATIC, REVERSE, Term, mass_unit
from incsvr.tracing.vocabulary import ROTOR_SPEED
from incsvr.vehicle import Parameter, Vehicle
from incsvr.vehicle.equation import STAGES
from service.wire import ModelSnapshot
from service.wire.json_text import read_json

CURVE_RATES = 101
"""Rates of an exported curve."""
EXPECTED_FILE = "give what `incsvr trace … --json FILE` or `incsvr fit … --json FILE` wrote"
IN_VEHICLE = ("inertia", "torque_lag", "torque_asymmetry", "bias_torque")
"""Traced effects that a vehicle's model has."""


@dataclass(frozen=True, slots=True)
class Learned:
    """The learned model of one axis; an end of an interval is NaN where nobody knows it.

    Attributes:
        source: where it comes from, for people.
        axis: the axis's name.
        inertia: of body and water together: the declared one, or the traced one where that is another.
        linear, quadratic: N_r and N_{r|r|}, positive where damping opposes.
        rate, damping: (n,) the curve over the rates that were learned.
        sigma: (n,) the standard deviation of one sample about it; None where it is not known.
        doubt: (n,) its own standard deviation; None likewise.
        noise: the samples' own deviation; None likewise.
        effects: what was traced beside the damping, as `to_dict` gives it.
        beaten_by: what predicts unseen data best, by its name in a trace; empty where nobody knows.
    """

    source: str
    axis: str
    inertia: Interval
    linear: Interval
    quadratic: Interval
    rate: Array
    damping: Array
    sigma: Array | None
    doubt: Array | None
    noise: float | None
    effects: tuple[Mapping[str, Any], ...]
    beaten_by: str = ""

    @property
    def form_error(self) -> float:
        """The error of the two coefficients against the curve: root mean square over the learned rates."""
        form = self.linear.estimate * self.rate + self.quadratic.estimate * self.rate * np.abs(self.rate)
        return root_mean_square(form - self.damping)

    @property
    def _units(self) -> tuple[str, str]:
        """The units of the axis's rate and effort."""
        return ("m/s", "N") if AXES[self.axis].along else ("rad/s", "N m")

    def vehicle(self) -> Vehicle:
        """A vehicle with this axis alone."""
        axis, found = self.axis, dict[tuple[str, str], Interval]()
        for effect in self.effects:
            found |= {(effect["effect"], name): Interval(**p) for name, p in effect["parameters"].items()}
        terms = {Term(axis, LINEAR): Parameter(*self.linear), Term(axis, QUADRATIC): Parameter(*self.quadratic)}
        if reverse := found.get(("torque_asymmetry", "reverse_efficiency")):
            terms[Term(axis, REVERSE)] = Parameter(1.0 - reverse.estimate, 1.0 - reverse.high, 1.0 - reverse.low)
        if bias := found.get(("bias_torque", "moment_nm")):
            terms[Term(axis, BIAS)] = Parameter(-bias.estimate, -bias.high, -bias.low)
        lag = found.get(("torque_lag", "time_constant_s"))
        lags = {} if lag is None else {axis: Parameter(*lag)}
        of_rotors = any(each["effect"] == "torque_lag" and each.get("shape") == ROTOR_SPEED for each in self.effects)
        thrust = {axis: {STAGES["spin"]: lags.pop(axis)}} if of_rotors else {}
        fastest = np.where(np.array(list(AXES)) == axis, np.abs(self.rate).max(), 0.0)
        mass = {(axis, axis): Parameter(*self.inertia)}
        return Vehicle(self.source, (axis,), (axis,), mass, terms, lags, fastest, self._doubts(), thrust)

    def figures(self) -> Iterator[tuple[str, Interval, str]]:
        """The figures by name, with their units."""
        rate, effort = self._units
        yield "N_r", self.linear, Term(self.axis, LINEAR).unit
        yield "N_r|r|", self.quadratic, Term(self.axis, QUADRATIC).unit.replace("²", "^2")
        yield "inertia", self.inertia, mass_unit(self.axis, self.axis).replace("²", "^2")
        yield "rate_low", _alone(self.rate[0]), rate
        yield "rate_high", _alone(self.rate[-1]), rate
        yield "form_error_rms", _alone(self.form_error), effort
        if self.noise is not None:
            yield "noise", _alone(self.noise), effort
        for effect in self.effects:  # the unit of a traced parameter is in its name
            yield from ((f"{effect['effect']}.{name}", Interval(**p), "") for name, p in effect["parameters"].items())

    def to_dict(self) -> dict[str, Any]:
        """Everything, the curve with its uncertainty."""
        return {
            "source": self.source,
            "equation": "I dr/dt + N_r r + N_r|r| r|r| = torque",
            "coefficients": {"N_r": self.linear._asdict(), "N_r|r|": self.quadratic._asdict()},
            "inertia": self.inertia._asdict(),
            "valid": [self.rate[0], self.rate[-1]],
            "form_error_rms": self.form_error,
            "noise": self.noise,
            "effects": list(self.effects),
            "curve": {"rate": self.rate, "damping": self.damping, "sigma": self.sigma, "doubt": self.doubt},
        }

    def _doubts(self) -> tuple[str, ...]:
        rate, effort = self._units
        doubts = [
            f"from {self.rate[0]:.4g} to {self.rate[-1]:.4g} {rate} the two coefficients miss the learned curve by "
            f"{self.form_error:.3g} {effort} (RMS) of up to {np.abs(self.damping).max():.3g} {effort}"
        ]
        if min(self.linear.estimate, self.quadratic.estimate) < 0.0:
            doubts.append("one of the two drives instead of damping: beyond these rates a simulator may run away")
        for name, p in zip(COEFFICIENT_NAMES, (self.linear, self.quadratic), strict=True):
            note = None if math.isnan(p.low) else negative_drag(name, p.low, p.high)
            doubts += [] if note is None else [note]
        for effect in self.effects:
            name, rivals = effect["effect"], ", ".join(effect["cannot_tell_from"])
            if rivals or name not in IN_VEHICLE:
                values = ", ".join(f"{key} = {p['estimate']:.4g}" for key, p in effect["parameters"].items())
                there = "" if name in IN_VEHICLE else ", which is not in this model"
                doubts.append(f"traced: {name}: {values}{f' (or {rivals})' if rivals else ''}{there}")
        return tuple(doubts)


def of_snapshot(snapshot: ModelSnapshot, source: str, axis: str = YAW.name) -> Learned:
    """The model that a learner serves.

    Raises:
        BadInput: nothing was learned yet.
    """
    model = snapshot.model
    trained = model.trained_range
    if trained is None or not trained[0] < trained[1]:
        raise BadInput(f"{source}: nothing was learned yet; export after the vehicle has turned both ways")
    at = np.linspace(*trained, CURVE_RATES)
    curve = model.predict(at)
    if model.several is not None:
        usual = zip(model.several.others, model.several.usual.tolist(), strict=True)
        source += "; a slice of damping over several velocities, at " + ", ".join(f"{n} {v:.3g}" for n, v in usual)
    linear, quadratic = coefficients(model).values()
    inertia, effects = _with_effects(snapshot.inertia, snapshot.effects)
    drawn = (at, curve.damping, curve.sigma, curve.doubt)
    return Learned(source, axis, inertia, linear, quadratic, *drawn, snapshot.noise, effects)


def of_file(path: Path) -> Learned:
    """The model of a file by `incsvr trace` or `incsvr fit`.

    Raises:
        BadInput: it is none of these; the sentence names the file.
    """
    try:
        found = read_json(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"{path}: cannot be read ({error}); {EXPECTED_FILE}") from None
    except ValueError as error:
        raise BadInput(f"{path}: this is no JSON ({error}); {EXPECTED_FILE}") from None
    try:
        return _of_fit(found, path) if "curve" in found else _of_trace(found, path)
    except (KeyError, TypeError, ValueError, AttributeError):
        raise BadInput(f"{path}: this contains no learned damping; {EXPECTED_FILE}") from None


def _of_fit(found: Mapping[str, Any], path: Path) -> Learned:
    linear, quadratic = (Interval(**found["coefficients"][name]) for name in COEFFICIENT_NAMES)
    curve = {name: np.array(each, dtype=np.float64) for name, each in found["curve"].items()}
    if "doubt" not in curve:  # of an earlier release, which called it sigma
        curve["doubt"] = curve.pop("sigma")
    drawn = (curve["rate"], curve["damping"], curve.get("sigma"), curve["doubt"])
    inertia, axis = _alone(found["inertia"]), found.get("axis", YAW.name)
    return Learned(f"incsvr fit, {path.name}", axis, inertia, linear, quadratic, *drawn, None, ())


def _of_trace(found: Mapping[str, Any], path: Path) -> Learned:
    model, axis = found["model"], found.get("axis", YAW.name)
    rate, damping = np.array(model["rate"]), np.array(model["damping"])
    terms = np.column_stack((rate, rate * np.abs(rate)))
    linear, quadratic = (_alone(each) for each in np.linalg.lstsq(terms, damping, rcond=None)[0])
    inertia, effects = _with_effects(model["inertia"], found["effects"])
    source = f"incsvr trace, {path.name}"
    beaten_by = found.get("error", {}).get("best", {}).get("name", "")
    return Learned(source, axis, inertia, linear, quadratic, rate, damping, None, None, None, effects, beaten_by)


def _alone(value: float) -> Interval:
    """A figure whose interval nobody knows."""
    return Interval(float(value), math.nan, math.nan)


def _with_effects(
    inertia: float, effects: Sequence[Mapping[str, Any]]
) -> tuple[Interval, tuple[Mapping[str, Any], ...]]:
    """The inertia in force, and the effects."""
    named = tuple(_effect(each) for each in effects)
    traced = [each["parameters"]["inertia_kg_m2"] for each in named if each["effect"] == "inertia"]
    return Interval(**traced[0]) if traced else _alone(inertia), named


def _effect(found: Mapping[str, Any]) -> Mapping[str, Any]:
    spans = found.get("interval") or {}
    parameters = {
        name: Interval(float(value), *(spans.get(name) or (math.nan, math.nan)))._asdict()
        for name, value in found["parameters"].items()
        if isinstance(value, int | float) and math.isfinite(value)
    }
    rivals = list(found.get("cannot_tell_from") or ())
    named = {"effect": found["effect"], "parameters": parameters, "cannot_tell_from": rivals}
    return named | ({"shape": found["shape"]} if "shape" in found else {})
