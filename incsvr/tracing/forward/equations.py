"""The forward form: what is known at the beginning of a cell predicts the rise of the rate in it.

    I₀ (r[k+1] − r[k])/h = T(τ) − d(r̄) − Σ θ φ + noise,      r̄ = r[k] + h r′[k] (eᶻ − 1 − z)/z²,   z = −h d′(r[k])/I,

with T the chain of thrust effects, r′ the acceleration that the model predicts at k and r̄ the mean rate of the cell,
exact for linear damping and a held torque (an exponential integrator; a cell in which the vehicle settles far is cut
into parts). Written for regression,

    T(τ) − I₀ Δr/h = d(r̄) + Σ θ φ + shift · ∂τ/∂t + noise.

An Euler step, r̄ = r[k], would not do: its error has the shape of an inertia. Everything on the right is known at k,
so that a controller which answers the rate does no harm. The effects' physics is the catalogue's (incsvr/effects).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from incsvr.effects import Effect, Signals, Term
from incsvr.effects.even_table import EvenTable
from incsvr.tracing.forward.damping import DampingBasis
from incsvr.tracing.forward.grid import Grid

Array = NDArray[np.float64]

TABLE = 801
"""Values of the damping's table."""

LINEAR, FINEST = 0.15, 6
"""Decay of the rate in a part of a cell up to which the drag is linear in it; and parts at most."""


@dataclass(frozen=True, slots=True)
class Part:
    """An effect with its values, as a hypothesis holds it."""

    effect: Effect
    term: Term

    @property
    def name(self) -> str:
        return self.effect.name

    @property
    def thrust(self) -> bool:
        """Whether it stands between command and thrust, where nothing about it is linear."""
        return self.effect.acts == "thrust"

    @property
    def searched(self) -> bool:
        """Whether it has a parameter that no linear regression finds."""
        return self.thrust or self.effect.searched

    @property
    def parameter(self) -> float:
        """The parameter that is searched: of thrust effects the coefficient, unless that is one by nature."""
        return self.term.coefficients[0] if self.thrust and not self.effect.fixed_coefficient else self.term.inner[-1]

    def moved(self, value: float) -> Part:
        """The same with another value of the searched parameter."""
        if self.thrust and not self.effect.fixed_coefficient:
            return Part(self.effect, replace(self.term, coefficients=(value,)))
        return Part(self.effect, replace(self.term, inner=(*self.term.inner[:-1], value)))


@dataclass(frozen=True, slots=True)
class Linear:
    """The linear part of a fitted model, from which the next pass predicts.

    Attributes:
        basis: of the damping.
        damping: (KNOTS,) its coefficients [N m].
        parts: the effects with their values.
        loss: (n,) Σ θ φ of all but damping and inertia [N m].
    """

    basis: DampingBasis
    damping: Array
    parts: tuple[Part, ...]
    loss: Array

    def damping_at(self, rate: Array) -> Array:
        """d(r) [N m]."""
        return np.asarray(self.damping @ self.basis.columns(rate))


@dataclass(frozen=True, slots=True)
class Prediction:
    """What a model predicts from the beginning of each cell.

    Attributes:
        signals: of which the effects' columns are built; the rate is the mean over the cell.
        path: (m, n) mean rate in each of m parts of the cell, over which the damping is averaged [rad/s].
    """

    signals: Signals
    path: Array


def thrust(signals: Signals, parts: Sequence[Part]) -> Array:
    """(n,) T(τ): the torque behind all thrust effects, from command to thrust [N m]."""
    moment = signals.torque
    if not signals.edges.size:
        signals = replace(signals, edges=np.stack([signals.rate, signals.rate]))
    for part in sorted((p for p in parts if p.thrust), key=lambda p: p.effect.stage):
        moment = part.effect.thrust(moment, signals, part.term)
    return moment


def assumed_inertia(declared: float, parts: Sequence[Part]) -> float:
    """I₀ + ΔI as far as it is known [kg m²]."""
    change = sum(p.term.coefficients[0] for p in parts if p.effect.acts == "inertia" and p.term.coefficients)
    return max(declared + change, 0.05 * declared)


def predicted(grid: Grid, model: Linear) -> Prediction:
    """What the model predicts from the beginning of each cell."""
    s = grid.signals
    inertia = assumed_inertia(s.inertia, model.parts)
    moment = thrust(s, model.parts)
    limit = 1.5 * float(max(np.max(np.abs(s.rate)), 1e-9))
    rates = np.linspace(-limit, limit, TABLE)
    drag = EvenTable(-limit, 2.0 * limit / (TABLE - 1), model.damping_at(rates))
    path, end = _path(s, drag, 2.0 * limit / (TABLE - 1), moment - model.loss, inertia)
    middle = np.clip(np.mean(path, axis=0), -limit, limit)
    damping = np.mean([drag(rate) for rate in path], axis=0)
    seen = replace(
        s,
        rate=middle,
        ends=middle,
        edges=np.stack([s.rate, np.clip(end, -limit, limit)]),
        damping=damping,
        drag=drag,
        acceleration=(moment - damping - model.loss) / inertia,
        applied=moment,
        command=s.torque,
        expected=s.torque,
        predicted_torque=s.torque,
        residual=np.zeros(len(s)) if not s.residual.size else s.residual,
    )
    return Prediction(seen, path)


def _path(s: Signals, drag: EvenTable, nudge: float, push: Array, inertia: float) -> tuple[Array, Array]:
    """(m, n) mean rates of the cell's m parts and (n,) the rate at its end: in each part the drag is linear, so that
    the
    step is exact (exponential Euler; M. Hochbruck, A. Ostermann, Acta Numerica 19, 2010)."""

    def decay(rate: Array, step: float) -> Array:
        slope = (drag(rate + nudge) - drag(rate - nudge)) / (2.0 * nudge)
        z = np.clip(-step * slope / inertia, -20.0, 0.5)
        return np.where(np.abs(z) < 1e-4, 1e-4, z)

    parts = int(np.clip(np.ceil(-float(np.min(decay(s.rate, s.step))) / LINEAR), 1, FINEST))
    step, rate, path = s.step / parts, s.rate, list[Array]()
    for _ in range(parts):
        z, gain = decay(rate, step), step * (push - drag(rate)) / inertia
        path.append(rate + gain * (np.expm1(z) - z) / z**2)
        rate = rate + gain * np.expm1(z) / z
    return np.array(path), rate


def columns(part: Part, signals: Signals) -> Array:
    """(c, n) regressors of an effect that is no thrust effect."""
    return np.asarray(part.effect.columns(signals, part.term.inner, part.term.coefficients).T)


def target(grid: Grid, moment: Array) -> Array:
    """(n,) T(τ) − I₀ Δr/h, what damping and effects must make up for [N m]."""
    return np.asarray(moment - grid.signals.inertia * grid.rise / grid.cell)
