"""What the methods of one split are given: recordings, and the same as cells that every model is judged on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.vehicles.splits import Split
from incsvr.effects import Signals
from incsvr.numerics import Array
from incsvr.plant.axes import AXES, VELOCITIES, Axis
from incsvr.plant.body import Coupled
from incsvr.tracing import innovations
from incsvr.tracing.cells import cut
from incsvr.tracing.channels import usable_channels
from incsvr.tracing.model import TracedModel
from incsvr.tracing.torque_nature import TorqueNature
from service.commands import other_velocities
from service.commands.trace import runs_of
from service.recordings.recording import Recording
from service.recordings.recording_csv import read

TABLE_REACH = 1.5
"""How far the table of a learned curve reaches, in the fastest measured velocities."""
TABLE_NODES = 801
"""Nodes of a curve's table."""


@dataclass(frozen=True, slots=True)
class Material:
    """What the methods of one split are given.

    Attributes:
        inertia: declared [kg m²].
        axis: whose motion it is.
        fitted, unseen: recordings.
        there, here: the same as cells, with every channel that may drive a model; `here` is what they are judged on.
        others: the velocities that are recorded beside the axis's own.
        coupled: the axis in its body, where the mass matrix is known.
    """

    inertia: float
    axis: Axis
    fitted: Sequence[Recording]
    unseen: Sequence[Recording]
    there: Signals
    here: Signals
    others: tuple[str, ...]
    coupled: Coupled | None

    @staticmethod
    def of(split: Split, folder: Path) -> Material:
        axis = AXES[split.axis]
        fitted, unseen = (
            [read(folder / split.vehicle / f"{name}.csv", axis=axis, rate_limit=axis.fastest) for name in names]
            for names in (split.fitted, split.unseen)
        )
        runs, rest = runs_of(fitted), runs_of(unseen)
        names, _ = usable_channels([*runs, *rest])
        names += ["heading"] * all("heading" in run.channels for run in (*runs, *rest))
        how = replace(innovations.cutting(runs, split.inertia, TorqueNature(held=True, noisy=False)), divide=1)
        there, here = (cut(each, split.inertia, names, how).signals for each in (runs, rest))
        return Material(
            split.inertia, axis, fitted, unseen, there, replace(here, origin=there.origin),
            tuple(name for name in VELOCITIES if name in there.channels),
            other_velocities.coupled_axis(split.mass_matrix, None, axis, [*fitted, *unseen]),
        )  # fmt: skip

    def curve(self, damping: Callable[[Array], Array]) -> TracedModel:
        """I ṙ + d(r) = τ, as a model that simulates."""
        fastest = TABLE_REACH * max(float(np.max(np.abs(each.rate))) for each in (self.there, self.here))
        rates = np.linspace(-fastest, fastest, TABLE_NODES)
        s = self.there
        return TracedModel(self.inertia, rates, damping(rates), (), 0.0, s.block, s.scale, s.origin)
