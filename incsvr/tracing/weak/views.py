"""The signals as each effect must see them, and how its columns answer the noise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from incsvr.effects import Effect, Signals
from incsvr.effects.even_table import EvenTable
from incsvr.tracing.run import Array
from incsvr.tracing.weak.disturbance_response import BEFORE, PARTS
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.whitening import Fit

REST = 3
"""Blocks after one that turns the vehicle in which nothing does: one in which it stops, and until the next begins."""

MOST_REMOVED = 0.8
"""Most of the residual that is taken off the torque to tell the command."""


class Views:
    """The signals as each effect must see them, given what the others take: from command to thrust, stage by stage."""

    def __init__(self, problem: Problem, fitted: Fit, terms: Sequence[tuple[Effect, Array, tuple[float, ...]]]) -> None:
        s = problem.signals
        noise_fraction = s.torque_noise_fraction
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
        drag = EvenTable(float(problem.grid[0]), float(problem.grid[1] - problem.grid[0]), curve)
        damping = drag(s.rate)
        lost = sum((loss for _, loss in self._stages), np.zeros(len(s)))
        self._needed = inertia * s.acceleration + damping + outside
        self._problem, self._jump_noise, self._ar = problem, fitted.jump_noise, fitted.ar
        # what of the residual is torque noise, n = f u with its fraction f, and what turned the vehicle, w = (f − 1) u
        self._driven = (1.0 - noise_fraction) * residual
        command = problem.command
        self._known = command.levels if s.known else None
        known = self._known if command.exact else None
        self._command = s.torque - noise_fraction * residual if known is None else known
        given = (s.torque if known is None else known) - lost
        self._lost = lost
        # Without its part of u the torque shares nothing with u. But an effect that is not yet known is in u as well:
        # were all of u taken off, what is left would be the model's own opinion.
        removed = min(noise_fraction, MOST_REMOVED)
        self._expected = command.smoothed_torque - removed * residual
        uncertainty = float(np.sqrt(removed * (1.0 - removed))) * fitted.scale
        self._predicted_torque = self._expected
        if known is not None:
            self._expected = self._predicted_torque = known
            uncertainty = 0.0
        elif noise_fraction > MOST_REMOVED:
            # the smoothed torque's shape within the block stays
            moved = command.predicted_torque - problem.blocks.mean(command.smoothed_torque)
            self._predicted_torque = command.smoothed_torque + problem.blocks.spread(moved, len(s))
            if command.stays:
                # at rest within a dead band nothing else tells the command from a noise that lasts
                self._expected, uncertainty = self._predicted_torque, 0.0
        self._signals = replace(
            s, damping=damping, drag=drag, residual=residual, uncertainty=uncertainty, known=known is not None,
            applied=noise_fraction * self._needed + (1.0 - noise_fraction) * given if known is None else given,
        )  # fmt: skip
        self._cache: dict[int, Signals] = {}

    def jacobian(self, effect: Effect, inner: tuple[float, ...], coefficients: tuple[float, ...], mean: Array) -> Array:
        """(2, n_b, c) how the effect's columns answer the noise of their own block; `mean` (n_b, c) are their means.

        The first by which the residual grows with the noise, the second by which it is held back: a thrust effect sees
        torque and motion without their part of the residual, so that the residual is in what it sees.
        """
        if effect.acts == "thrust" and effect.curved and len(coefficients) == 1 and coefficients[0] != 0.0:
            # its columns are but tangents: what answers is the loss itself
            def lost(s: Signals) -> Array:
                columns = effect.columns(s, inner, coefficients)
                offset = effect.offset(s, coefficients, columns)
                return columns if offset is None else columns + offset[:, None] / coefficients

            return self._passed_on(effect, lambda s: effect.columns(s, inner, coefficients), mean, lost)
        return self.answers(effect, lambda s: effect.columns(s, inner, coefficients), mean)

    def answers(self, effect: Effect, columns: Callable[[Signals], Array], mean: Array) -> Array:
        """`jacobian` of any columns that are made of the signals as the effect sees them."""
        s, blocks = self._signals, self._problem.blocks
        if effect.acts == "inertia":
            risen = s.turning * self._problem.disturbance_response.rise / blocks.period
            return np.stack([np.tile(risen[:, None], mean.shape[1]), np.zeros_like(mean)])
        if effect.acts == "thrust":
            return self._passed_on(effect, columns, mean)
        if effect.acts not in ("motion", "damping") or s.turning == 0.0:
            return np.zeros((2, *mean.shape))
        nudge = 1e-3 * float(np.std(s.rate))

        def answer(rate_response: Array) -> Array:
            rate = s.rate + nudge * rate_response
            answered = s.turning * self._problem.feedback * nudge * rate_response
            there = replace(s, rate=rate, damping=s.drag(rate), applied=s.applied - answered)
            return (blocks.mean(columns(there)) - mean) / nudge

        jacobian = s.turning * self._through_rate(effect, answer)
        return np.stack([jacobian, np.zeros_like(jacobian)])

    def _through_rate(self, effect: Effect, answer: Callable[[Array], Array]) -> Array:
        """(n_b, c) how columns answer the noise of their own block by way of the rate.

        Args:
            effect: what they belong to.
            answer: block means (n_b, c) that the columns gain by a rate (n,), in parts of what it gains.
        """
        blocks, response = self._problem.blocks, self._problem.disturbance_response
        if not effect.lingers:
            return response.mean[:, None] * answer(self._rate_response)
        inside = np.arange(blocks.size) / blocks.size * PARTS
        cells = blocks.first[:, None] + np.arange(blocks.size)
        rate_response = np.zeros(len(self._signals))
        # some blocks turn the vehicle, to either side by chance, and the next turns it back: so what the columns keep
        # of earlier blocks is told from what they owe to the own
        marks = np.arange(BEFORE, len(blocks) - 1, BEFORE + REST)
        sign = np.random.default_rng(0).choice([-1.0, 1.0], marks.size)
        part = np.arange(response.path.size)
        for k in range(BEFORE + 1):
            path = np.interp(k * PARTS + inside, part, response.path)
            rate_response[cells[marks - BEFORE + k]] = np.outer(sign, path)
        rate_response[cells[marks + 1]] = np.outer(sign, response.path[-1] * (1.0 - inside / PARTS))
        gained = answer(rate_response)
        own = gained[marks] - sum(weight * gained[marks - BEFORE + k] for k, weight in enumerate(response.predictor))
        return np.tile(sign @ own / marks.size, (len(blocks), 1))

    @cached_property
    def _rate_response(self) -> Array:
        """(n,) the rate within each block, in parts of what it is in the mean over the block."""
        blocks, response = self._problem.blocks, self._problem.disturbance_response
        # the edge is half each block's
        middle = ((np.arange(blocks.size) + 0.5) / blocks.size * PARTS).astype(np.intp)
        rate_response = np.zeros(len(self._signals))
        cells = blocks.first[:, None] + np.arange(blocks.size)
        rate_response[cells.ravel()] = (response.rate_within[:, middle] / response.mean[:, None]).ravel()
        return rate_response

    def gyro_noise_correction(self, effect: Effect, columns: Array) -> Array:
        """(c,) for `whitening.fit`: what the gyro mistakes for a turn is in Δr as much as what is one."""
        s = self._signals
        return np.full(
            columns.shape[1], s.torque_noise_fraction * s.gyro / s.inertia if effect.acts == "inertia" else 0.0
        )

    def _passed_on(
        self, effect: Effect, columns: Callable[[Signals], Array], mean: Array,
        lost: Callable[[Signals], Array] | None = None,
    ) -> Array:  # fmt: skip
        """`jacobian` of a thrust effect. Alone it weighs nothing; beside an inertia the two are weighed together, or
        half the thrust, half the inertia and half the drag would explain everything with half the noise."""
        s, stays = self.of(effect), self._problem.command.stays
        # what lingers moves the noise of a jump to other blocks, and takes none
        with_jump_noise = self._jump_noise > 0.0 and not effect.lingers
        instant = self._mistimed(s, columns, mean) if with_jump_noise else np.zeros_like(mean)
        if s.known:  # of the noise nothing but the instants of jumps is in what the effect sees
            return np.stack([-instant, np.zeros_like(mean)])
        nudge, estimated = 1e-3 * float(np.std(s.torque)), s.torque_noise_fraction > MOST_REMOVED
        there = replace(
            s,
            applied=s.applied + s.turning * nudge,
            command=s.command - s.torque_noise_fraction * nudge,
            expected=s.expected - (0.0 if estimated and stays else min(s.torque_noise_fraction, MOST_REMOVED) * nudge),
            predicted_torque=s.predicted_torque - (0.0 if estimated else s.torque_noise_fraction * nudge),
        )
        passed: Array = (self._problem.blocks.mean(columns(there)) - mean) / nudge
        grown = passed + self._fed_back(effect, columns, mean, lost)
        return np.stack([grown - instant if estimated else grown, passed])

    def _mistimed(self, s: Signals, columns: Callable[[Signals], Array], mean: Array) -> Array:
        """(n_b, c) of the torque's noise what is lost with the thrust in blocks where the command jumped.

        No earlier block predicts it there, and what passes for noise is the jump's instant, between two samples. It is
        in its own block, and in what is predicted of the next.
        """
        blocks, soon = self._problem.blocks, 0.1 * s.step
        moved = blocks.mean(s.later(s.torque, soon) - s.torque)
        there = replace(s, predicted_torque=s.later(s.predicted_torque, soon))
        if s.known or self._problem.command.stays:
            there = replace(there, expected=s.later(s.expected, soon))
        if s.known:
            there = replace(there, command=s.later(s.command, soon))
        jumped = (blocks.mistimed > 0.0) & (np.abs(moved) > 1e-9 * np.max(np.abs(moved)))
        lost = (blocks.mean(columns(there)) - mean) / np.where(jumped, moved, 1.0)[:, None]
        lost = np.where(jumped[:, None], np.clip(lost, -1.0, 1.0), 0.0)
        # what predicts the next three blocks holds the instant, too: it is taken from their innovations as well
        instant = self._jump_noise * np.square(blocks.mistimed)
        louder, taken = np.ones(len(blocks)), np.zeros(mean.shape)
        for later, part in enumerate(np.square([1.0, *self._ar])):
            louder[later:] += part * instant[: instant.size - later]
            taken[later:] += part * (instant[:, None] * lost)[: instant.size - later]
        return s.torque_noise_fraction * taken / louder[:, None]

    def _fed_back(
        self, effect: Effect, columns: Callable[[Signals], Array], mean: Array,
        lost: Callable[[Signals], Array] | None,
    ) -> Array | float:  # fmt: skip
        """(n_b, c) how a thrust effect's columns answer the noise of their own block through a controller, if any."""
        problem, s = self._problem, self.of(effect)
        if problem.feedback == 0.0 or s.turning == 0.0:
            return 0.0
        nudge = 1e-3 * float(np.std(s.rate))
        before = mean if lost is None else problem.blocks.mean(lost(s))
        columns = lost or columns

        def answer(rate_response: Array) -> Array:
            answered = problem.feedback * nudge * rate_response
            there = replace(
                s,
                command=s.command - answered,
                expected=s.expected - answered,
                predicted_torque=s.predicted_torque - answered,
            )
            return (problem.blocks.mean(columns(there)) - before) / nudge

        return s.turning * self._through_rate(effect, answer)

    def of(self, effect: Effect) -> Signals:
        """The signals for one effect."""
        if effect.acts != "thrust":
            return self._signals
        if effect.stage not in self._cache:
            s = self._problem.signals
            before = sum((loss for stage, loss in self._stages if stage < effect.stage), np.zeros(len(s)))
            after = sum((loss for stage, loss in self._stages if stage > effect.stage), np.zeros(len(s)))
            # what shifts the thrust in time must know what the command was when; what bends it would bend its noise
            known = self._known if self._problem.command.exact or effect.lingers else None
            self._cache[effect.stage] = replace(
                self._signals,
                applied=after + (self._needed + self._driven if known is None else known - self._lost),
                command=(known if known is not None else s.torque if effect.shifts else self._command) - before,
                expected=self._expected - before,
                predicted_torque=self._predicted_torque - before,
                known=known is not None,
            )
        return self._cache[effect.stage]
