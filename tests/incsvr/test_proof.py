"""Held-out pieces are driven by what the other blocks told, and by nothing else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.tracing.weak.hypothesis import nothing
from incsvr.tracing.weak.modelled import model_of
from incsvr.tracing.weak.validation import FOLDS, Validation
from tests.incsvr.turning import command, instants, turning

TIME = instants(600.0)


@pytest.mark.parametrize("seed", [0, 3])
def test_the_drag_of_rates_that_only_a_held_out_piece_holds_goes_on_from_the_others(seed: int) -> None:
    """Where none of the fitted blocks was, the spline of d(r) is anything; the model's table ends before that."""
    fast = (TIME > 341.0) & (TIME < 359.0)
    problem = turning(seed, np.where(fast, -90.0, 0.4 * command(seed, TIME)))
    proof = Validation.of(problem, None)
    errors = proof.errors(nothing(problem))
    rows = [k for fold in range(FOLDS) for k in range(len(proof.pieces))[fold::FOLDS]]
    fastest = int(np.argmax([np.max(np.abs(rate)) for rate in errors.measured]))
    used = np.ones(len(problem.blocks), dtype=bool)
    for piece in proof.pieces[rows[fastest] % FOLDS :: FOLDS]:
        used[piece] = False
    less = replace(problem, blocks=problem.blocks.only(used))
    told = model_of(less, nothing(less))
    edge, drag = -told.rate[0], -told.damping[0]
    steady = edge * np.sqrt(90.0 / drag)
    assert steady > 1.3 * edge
    assert np.min(errors.simulated[fastest]) == pytest.approx(-steady, rel=0.03)
