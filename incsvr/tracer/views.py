"""The signals as each effect must see them, and how its columns answer the noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from incsvr.effects import Effect, Signals
from incsvr.tracer.problem import Problem
from incsvr.tracer.run import Array
from incsvr.tracer.whitening import Fit


class Views:
    """The signals as each effect must see them, given what the others take: from command to thrust, stage by stage."""

    def __init__(self, problem: Problem, fitted: Fit, terms: Sequence[tuple[Effect, Array, tuple[float, ...]]]) -> None:
        s = problem.signals
        share = s.share
        residual = problem.blocks.spread(fitted.residual, len(s))
        outside, inertia = np.zeros(len(s)), s.inertia
        self._stages: list[tuple[int, Array]] = []
        for effect, loss, coefficients in terms:
            if effect.acts == "thrust":
                self._stages.append((effect.stage, loss))
            elif effect.acts == "inertia":
                inertia += coefficients[0]
            else:
                outside = outside + loss
        curve = problem.grid_columns @ fitted.theta[: problem.grid_columns.shape[1]]
        damping = np.interp(s.rate, problem.grid, curve)
        lost = sum((loss for _, loss in self._stages), np.zeros(len(s)))
        self._needed = inertia * s.acceleration + damping + outside
        self._problem = problem
        given = s.torque - lost
        # what of the residual is torque noise, n = share · u, and what turned the vehicle, w = −(1 − share) u
        at = problem.blocks.first + 0.5 * problem.blocks.size
        smooth = np.interp(np.arange(len(s)), at, fitted.residual)
        self._noise, self._driven = share * smooth, (1.0 - share) * smooth
        # command as foretold from earlier blocks, so far as the torque is noisy: what is left shares nothing with u
        self._expected = s.torque
        if share > 0.02:
            mean = problem.blocks.mean(s.torque) - share * fitted.residual
            expected = share * problem.foretold + (1.0 - share) * mean
            self._expected = problem.blocks.spread(expected, len(s))
        self._plain = replace(
            s, damping=damping, residual=residual,
            applied=share * self._needed + (1.0 - share) * given,
        )  # fmt: skip
        # blended so that what w does to the one and the torque's noise to the other cancel: free of u
        self._foretold = share * s.acceleration + (1.0 - share) * (given - damping - outside) / max(inertia, 1e-9)
        self._cache: dict[int, Signals] = {}
        self._curve = curve

    def turned(self, effect: Effect, inner: tuple[float, ...], coefficients: tuple[float, ...], mean: Array) -> Array:
        """(n_b, c) how the effect's columns answer the noise of their own block; `mean` (n_b, c) are their means."""
        s, blocks = self._plain, self._problem.blocks
        if effect.acts == "inertia":
            return np.full_like(mean, s.turning / s.inertia)
        if effect.acts not in ("motion", "damping") or effect.slow or s.turning == 0.0:
            return np.zeros_like(mean)
        index = blocks.first[:, None] + np.arange(blocks.size)[None, :]
        since = np.zeros(len(s))
        since[index.ravel()] = np.tile(np.arange(blocks.size) / blocks.size, len(blocks))
        nudge = 1e-3 * float(np.std(s.rate))
        rate = s.rate + nudge * since
        there = replace(s, rate=rate, damping=np.interp(rate, self._problem.grid, self._curve))
        moved = blocks.mean(effect.columns(there, inner, coefficients))
        turned: Array = s.turning * blocks.period / s.inertia * (moved - mean) / nudge
        return turned

    def instrument(self, effect: Effect, columns: Array) -> Array:
        """(n_b, c) what stands for the effect's columns in the normal equations."""
        if effect.acts != "inertia" or self._plain.turning == 0.0:
            return columns
        return self._problem.blocks.mean(self._foretold)[:, None]

    def of(self, effect: Effect) -> Signals:
        """The signals for one effect."""
        if effect.acts != "thrust":
            return self._plain
        if effect.stage not in self._cache:
            s = self._problem.signals
            before = sum((loss for stage, loss in self._stages if stage < effect.stage), np.zeros(len(s)))
            after = sum((loss for stage, loss in self._stages if stage > effect.stage), np.zeros(len(s)))
            self._cache[effect.stage] = replace(
                self._plain,
                applied=self._needed + after + self._driven,
                command=s.torque - before - self._noise,
                expected=self._expected - before,
            )
        return self._cache[effect.stage]
