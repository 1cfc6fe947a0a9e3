"""What a fit leaves in doubt: its parameters along the axes of their covariance, and the instants of jumps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from incsvr.effects import catalogue
from incsvr.evidence import covariance
from incsvr.tracer.alignment import with_share
from incsvr.tracer.doubt import moved
from incsvr.tracer.hypothesis import Hypothesis, nothing, settle, views
from incsvr.tracer.run import Array
from tests.incsvr.turning import command, instants, turning

TIME = instants(400.0)


def test_the_axes_of_the_doubt_make_up_the_covariance() -> None:
    problem, known = turning(0, command(0, TIME), outside=8.0), catalogue()
    terms = [(known["bias_torque"], (), ()), (known["dead_zone/shifted"], (6.0,), ())]
    found = settle(problem, terms, nothing(problem))

    def parameters(h: Hypothesis) -> Array:
        of_terms = [x for e, t in zip(h.effects, h.terms, strict=True) for x in (*t.coefficients, *t.inner[-1:])]
        return np.array([*h.fit.theta[: problem.coarse.shape[1]], *of_terms])

    steps = np.array([parameters(version) - parameters(found) for version in moved(problem, found)])
    covered = covariance(problem, found)
    root = np.sqrt(np.diag(covered))
    np.testing.assert_allclose(steps.T @ steps / np.outer(root, root), covered / np.outer(root, root), atol=1e-6)


def test_what_takes_a_part_of_a_jump_takes_it_from_the_next_blocks_innovations_too() -> None:
    """They are foretold from the jump's block, and its instant is an error there."""
    problem, limit = with_share(turning(0, command(0, TIME)), 1.0), catalogue()["torque_saturation/limit"]
    base = nothing(problem)
    loud = replace(base, fit=replace(base.fit, loud=50.0, ar=np.array([0.9, 0.0, 0.0])))
    seen = views(problem, loud)
    mean = problem.blocks.mean(limit.columns(seen.of(limit), (40.0,), ()))
    grown, _ = seen.turned(limit, (40.0,), (), mean)
    jumped = problem.blocks.mistimed > 0.0
    after = np.concatenate([[False], jumped[:-1]]) & ~jumped
    second = np.concatenate([[False], after[:-1]]) & ~jumped & ~after
    assert np.mean(grown[jumped]) < -0.05
    assert np.mean(grown[after]) < -0.05
    assert not grown[second].any()
