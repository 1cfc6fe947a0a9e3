"""Other fits widen an interval by what they move beyond chance, and by nothing else."""

from __future__ import annotations

import numpy as np

from incsvr.model.fitting import Fit, Problem, fit
from incsvr.model.identification import plain_fit, structure_of
from incsvr.model.intervals import intervals
from incsvr.model.windows import cut
from incsvr.numerics import Streams
from tests.incsvr.model.turning import Turning, dive

MASS = "mass:yaw_rate"


def log(seed: int, inertia: float) -> Streams:
    return dive(Turning(inertia=inertia), seed, seconds=60.0, rate=10.0)


def again(found: Fit, run: Streams) -> Fit:
    """The structure fitted to another recording."""
    windows = found.problem.windows
    return fit(found.structure, found.theta, Problem(cut([run], found.structure, windows.step, 2.0)))


def test_what_another_fit_hardly_determines_does_not_widen_an_interval() -> None:
    run = log(5, 12.0)
    found = plain_fit(structure_of([run], ["yaw_rate"]), [run])
    poor = again(found, {name: (t[t < 9.0], v[t < 9.0]) for name, (t, v) in run.items()})
    alone, with_it = intervals(found)[MASS], intervals(found, [poor])[MASS]
    assert not alone.low < np.exp(poor.theta[MASS]) < alone.high
    assert with_it.high - with_it.low < 1.05 * (alone.high - alone.low)
    assert with_it.moved < 1.0


def test_but_a_change_beyond_chance_does() -> None:
    run = log(5, 12.0)
    found = plain_fit(structure_of([run], ["yaw_rate"]), [run])
    with_it = intervals(found, [again(found, log(6, 14.0))])[MASS]
    assert with_it.moved > 3.0
    assert with_it.low < 12.0 < with_it.high
    assert with_it.high > 13.5
