"""Predictions of models on data that their fit did not use: free runs, torque over blocks, and some scales ahead."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from incsvr.model.efforts import Stage
from incsvr.model.factors import Indices
from incsvr.model.fitting import Fit
from incsvr.model.left_out import left_out_errors
from incsvr.model.rivals import free_runs, free_windows
from incsvr.model.scales import motion_scale
from incsvr.model.series import period
from incsvr.model.simulation import predict
from incsvr.model.structure import Structure
from incsvr.model.windows import Windows, cut
from incsvr.numerics import Array
from incsvr.tracing.held_out import Ahead, Errors
from incsvr.tracing.recordings import Recordings
from incsvr.tracing.thresholds import HORIZON_SCALES, TORQUE_BLOCK_SCALES


@dataclass(frozen=True)
class Judge:
    """Recordings on which models are compared.

    Attributes:
        recordings: of one axis.
        structure: of the models, whose axis, channels and efforts they share.
        step: of the simulations [s].
        scale: of the motion [s].
        block: of the torque's error [s].
        excluded: whether each fold of the recordings is predicted by the fit without it, else all by the whole fit.
    """

    recordings: Recordings
    structure: Structure
    step: float
    scale: float
    block: float
    excluded: bool

    @property
    def sample(self) -> float:
        """The usual time between two samples of the velocity [s]."""
        return period(self.recordings.streams, self.recordings.axis)

    @cached_property
    def whole(self) -> Windows:
        """A window for each free run: a recording, or a fold of it."""
        return self._cut(np.inf)

    @cached_property
    def blocks(self) -> Windows:
        """A window for each block of the torque's error."""
        return self._cut(self.block)

    @cached_property
    def ahead(self) -> list[Windows]:
        """Windows for each of HORIZON_SCALES."""
        return [self._cut(max(scales * self.scale, self.sample)) for scales in HORIZON_SCALES]

    def _cut(self, horizon: float) -> Windows:
        return free_windows(self.structure, self.step, self.recordings.streams, horizon, self.excluded)

    def errors(self, model: Fit, free_runs_alone: bool = False) -> Errors:
        """The errors of a model."""
        whole, stamps = self.whole, times(self.whole)
        return Errors(
            tuple(stamps[part] for part in self._parts),
            tuple(whole.measured[part] for part in self._parts),
            self._free_runs(model),
            () if free_runs_alone else self.torque(model),
            () if free_runs_alone else tuple(self._ahead(model, windows) for windows in self.ahead),
        )

    @cached_property
    def _parts(self) -> list[slice]:
        return [part for part in self.whole.samples if part.stop > part.start]

    def _free_runs(self, model: Fit) -> tuple[Array, ...]:
        predicted = self._predicted(model, self.whole)
        return tuple(predicted[part] for part in self._parts)

    def next_samples(self, predictor: Fit, keeps: bool = False) -> tuple[Array, ...]:
        """(blocks,) of each recording, means over a block of the torque by which a predictor misses the next sample
        [N m]; where it only keeps the last velocity, of that torque.

        What is corrected by each sample owes nothing to what the torque answers: it is right in closed loop, too.
        """
        structure, problem = predictor.structure, predictor.problem
        windows = problem.windows
        if not self.excluded:
            windows = cut(self.recordings.streams, structure, windows.step, windows.step * windows.steps)
        if keeps:
            before = np.concatenate([[0.0], windows.measured[:-1]])
            first = np.concatenate([[True], np.diff(windows.window) > 0])
            errors = windows.measured - np.where(first, windows.starts[0, windows.window], before)
        elif self.excluded:
            errors = left_out_errors(predictor)
        else:
            point = np.array([[predictor.theta[name]] for name in predictor.names])
            errors = replace(problem, windows=windows).errors(
                predict(structure, point, windows, windows.starts[:, None])
            )[:, 0]
        size = max(round(self.block / self.sample), 1)
        torque = structure.inertia(predictor.theta, self.recordings.axis) / self.sample * errors
        run = windows.run[windows.window]
        return tuple(means(torque[run == k], size) for k in np.unique(run))

    def torque(self, model: Fit | None) -> tuple[Array, ...]:
        """(blocks,) of each recording, the torque that a model lacks as a mean over a block, so that it reaches the
        velocity measured at its end [N m]; without a model, for the block's first velocity to last."""
        windows = self.blocks
        last, lasted = ends(windows)
        inertia = model.structure.inertia(model.theta, self.recordings.axis) if model else 1.0
        predicted = windows.starts[0, windows.window] if model is None else self._predicted(model, windows)
        lacking = inertia * (windows.measured - predicted)[last] / lasted
        run = windows.run[windows.window[last]]
        return tuple(lacking[run == k] for k in np.unique(run))

    def efforts(self) -> tuple[Array, ...]:
        """(blocks,) of each recording, the mean effort [N m]."""
        windows = self.blocks
        mean = windows.effort(self.recordings.axis, "linear", Stage()).mean(axis=0)
        last, _ = ends(windows)
        run, mean = windows.run[windows.window[last]], mean[windows.window[last]]
        return tuple(mean[run == k] for k in np.unique(run))

    def _ahead(self, model: Fit, windows: Windows) -> Ahead:
        last, _ = ends(windows)
        full = windows.count[windows.window[last]] == windows.steps
        last = last[full]
        error = self._predicted(model, windows)[last] - windows.measured[last]
        change = windows.measured[last] - windows.starts[0, windows.window[last]]
        return Ahead(error, change, windows.measured[last])

    def _predicted(self, model: Fit, windows: Windows) -> Array:
        """(samples,) the model's velocities from the measured first one of each window."""
        return free_runs(model, windows, self.excluded, 10.0)


def judge(recordings: Recordings, model: Fit, fitted: Recordings, excluded: bool) -> Judge:
    """What compares models on recordings; `fitted` are those of their fit, whose time scale counts."""
    scale = motion_scale(fitted.streams, fitted.axis)
    sample = period(fitted.streams, fitted.axis)
    block = max(round(TORQUE_BLOCK_SCALES * scale / sample), 1) * sample
    return Judge(recordings, model.structure, model.problem.windows.step, scale, block, excluded)


def times(windows: Windows) -> Array:
    """(samples,) stamps [s]."""
    grids = [windows.grids[run] for run in windows.run]
    begins = np.array([each.origin for each in grids])
    edges = windows.first - np.array([each.first for each in grids])
    own = windows.window
    return np.asarray(begins[own] + windows.step * (edges[own] + windows.cell + windows.part))


def means(values: Array, size: int) -> Array:
    """Means of (n,) values over so many, and of the rest."""
    starts = np.arange(0, values.size, size)
    return np.asarray(np.add.reduceat(values, starts) / np.diff(np.append(starts, values.size)))


def ends(windows: Windows) -> tuple[Indices, Array]:
    """The last sample of each window that has any, and how long after the window's first edge it was taken [s]."""
    every = np.searchsorted(windows.window, np.arange(windows.first.size), side="right") - 1
    last = every[(every >= 0) & (windows.window[np.maximum(every, 0)] == np.arange(windows.first.size))]
    return last, windows.step * (windows.cell[last] + windows.part[last])
