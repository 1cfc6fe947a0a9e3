"""The exported model: coefficients of a learned curve, their error and range, inertia and traced effects.

The textbook's form is d(r) = N_r r + N_{r|r|} r|r|, positive where damping opposes the motion, in
I ṙ + d(r) = τ. Tools that count hydrodynamic derivatives (Fossen, SNAME) have both with the other sign.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.coefficients import COEFFICIENT_NAMES, coefficients, negative_drag
from incsvr.learning.model import Model
from incsvr.numerics import Array, root_mean_square
from service.wire import ModelSnapshot
from service.wire.json_text import read_json

CURVE_RATES = 101
"""Rates of an exported curve."""
EXPECTED_FILE = "give what `incsvr trace … --json FILE` or `incsvr fit … --json FILE` wrote"


@dataclass(frozen=True, slots=True)
class Value:
    """A figure with its interval of 95 %, None where nobody knows it."""

    estimate: float
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True, slots=True)
class Curve:
    """The damping itself at (n,) rates [rad/s]: damping, the deviation sigma of one sample about it, and its own
    doubt [N m], as far as they are known."""

    rate: Array
    damping: Array
    sigma: Array | None = None
    doubt: Array | None = None


@dataclass(frozen=True, slots=True)
class Effect:
    """An effect that was traced: its name and its parameters, with units in their names."""

    name: str
    parameters: Mapping[str, Value]
    cannot_tell_from: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class DampingModel:
    """The learned model of one axis.

    Attributes:
        source: where it comes from, for people.
        inertia: of body and water together [kg m²]: the declared one, or the traced one where that is another.
        linear, quadratic: N_r [N m s/rad] and N_{r|r|} [N m s²/rad²], positive where damping opposes.
        curve: over the rates that were learned.
        noise: the samples' own deviation [N m]; None where it is not known.
        effects: what was traced beside the damping.
    """

    source: str
    inertia: Value
    linear: Value
    quadratic: Value
    curve: Curve
    noise: float | None
    effects: tuple[Effect, ...]

    @property
    def valid(self) -> tuple[float, float]:
        """Lowest and highest rate that was learned; beyond, the coefficients are a guess [rad/s]."""
        return float(self.curve.rate[0]), float(self.curve.rate[-1])

    @property
    def form_error(self) -> float:
        """The error of the two coefficients against the curve: root mean square over the learned rates [N m]."""
        return root_mean_square(self.form(self.curve.rate) - self.curve.damping)

    def form(self, rate: Array) -> Array:
        """(n,) damping at (n,) rates by the two coefficients [N m]."""
        return np.asarray(self.linear.estimate * rate + self.quadratic.estimate * rate * np.abs(rate))

    def of(self, effect: str, parameter: str) -> Value | None:
        """A parameter of a traced effect; None where the effect was not found."""
        found = [each.parameters[parameter] for each in self.effects if each.name == effect]
        return found[0] if found else None

    def remark(self) -> list[str]:
        """The remarks on the two coefficients, as lines."""
        low, high = self.valid
        largest = float(np.abs(self.curve.damping).max())
        lines = [
            f"{self.source}",
            f"holds from {low:.4g} to {high:.4g} rad/s; there the two coefficients miss the learned curve by "
            f"{self.form_error:.3g} N m (RMS) of up to {largest:.3g} N m",
            f"N_r = {_in_words(self.linear)} N m s/rad, N_r|r| = {_in_words(self.quadratic)} N m s^2/rad^2, "
            "damping as positive",
            f"I = {_in_words(self.inertia)} kg m^2, body and water together",
        ]
        if min(self.linear.estimate, self.quadratic.estimate) < 0.0:
            lines.append("one of the two drives instead of damping: beyond these rates a simulator may run away")
        for name, value in zip(COEFFICIENT_NAMES, (self.linear, self.quadratic), strict=True):
            note = None if value.low is None or value.high is None else negative_drag(name, value.low, value.high)
            lines += [] if note is None else [note]
        for effect in self.effects:
            values = ", ".join(f"{name} = {_in_words(value)}" for name, value in effect.parameters.items())
            rivals = f" (or {', '.join(effect.cannot_tell_from)})" if effect.cannot_tell_from else ""
            lines.append(f"traced: {effect.name}: {values}{rivals}")
        return lines


def of_snapshot(snapshot: ModelSnapshot, source: str) -> DampingModel:
    """The model that a learner serves.

    Raises:
        BadInput: nothing was learned yet.
    """
    model = snapshot.model()
    trained = model.trained_range
    if trained is None or not trained[0] < trained[1]:
        raise BadInput(f"{source}: nothing was learned yet; export after the vehicle has turned both ways")
    at = np.linspace(*trained, CURVE_RATES)
    curve = model.predict(at)
    if model.several is not None:
        usual = zip(model.several.others, model.several.usual.tolist(), strict=True)
        source += "; a slice of damping over several velocities, at " + ", ".join(f"{n} {v:.3g}" for n, v in usual)
    drawn = Curve(at, curve.damping, curve.sigma, curve.doubt)
    return _with_effects(source, snapshot.inertia, model, drawn, snapshot.noise, snapshot.effects)


def of_file(path: Path) -> DampingModel:
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


def _of_fit(found: Mapping[str, Any], path: Path) -> DampingModel:
    linear, quadratic = (Value(**found["coefficients"][name]) for name in COEFFICIENT_NAMES)
    given = {name: np.array(each, dtype=np.float64) for name, each in found["curve"].items()}
    if "doubt" not in given:  # of an earlier release, which called it sigma
        given["doubt"] = given.pop("sigma")
    curve = Curve(**given)
    return DampingModel(f"incsvr fit, {path.name}", Value(float(found["inertia"])), linear, quadratic, curve, None, ())


def _of_trace(found: Mapping[str, Any], path: Path) -> DampingModel:
    model = found["model"]
    curve = Curve(np.array(model["rate"]), np.array(model["damping"]))
    return _with_effects(f"incsvr trace, {path.name}", model["inertia"], None, curve, None, found["effects"])


def _with_effects(
    source: str,
    inertia: float,
    model: Model | None,
    curve: Curve,
    noise: float | None,
    effects: Sequence[Mapping[str, Any]],
) -> DampingModel:
    named = tuple(_effect(each) for each in effects)
    declared = Value(float(inertia))
    traced = next((each.parameters["inertia_kg_m2"] for each in named if each.name == "inertia"), declared)
    if model is None:  # nobody knows how sure a traced curve is
        terms = np.column_stack((curve.rate, curve.rate * np.abs(curve.rate)))
        best = np.linalg.lstsq(terms, curve.damping, rcond=None)[0].tolist()
        linear, quadratic = Value(best[0]), Value(best[1])
    else:
        linear, quadratic = (Value(*each) for each in coefficients(model).values())
    return DampingModel(source, traced, linear, quadratic, curve, noise, named)


def _effect(found: Mapping[str, Any]) -> Effect:
    spans = found.get("interval") or {}
    parameters = {
        name: Value(float(value), *(spans.get(name) or (None, None)))
        for name, value in found["parameters"].items()
        if isinstance(value, int | float) and math.isfinite(value)
    }
    return Effect(found["effect"], parameters, tuple(found.get("cannot_tell_from") or ()))


def _in_words(value: Value) -> str:
    span = "" if value.low is None or value.high is None else f" (95 %: {value.low:.4g} to {value.high:.4g})"
    return f"{value.estimate:.4g}{span}"
