"""A whole vehicle, identified from simulated dives: parameters, errors, and what is said where data do not suffice."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.numerics import Array, Streams
from incsvr.vehicle import Identified, identify, on_grid
from incsvr.vehicle.fitting import Fit, student_weight
from incsvr.vehicle.intervals import intervals
from incsvr.vehicle.structure import Structure
from simulator.vehicles import BODIES
from simulator.vehicles import Vehicle as Body
from tests.worlds import swim


def dive(kind: str, seconds: float, seed: int) -> tuple[Body, Streams]:
    """A body drawn by the seed, and the log of a dive of it."""
    body = BODIES[kind](np.random.default_rng(seed))
    return body, swim(body, seconds, seed)


@cache
def torpedo() -> tuple[Body, Identified]:
    """A torpedo in the plane, identified from four minutes and judged on one."""
    body = BODIES["torpedo"](np.random.default_rng(41))
    motion = on_grid([swim(body, 240.0, 41)])
    return body, identify(motion, on_grid([swim(body, 60.0, 42)], motion.step), name="torpedo")


def test_inertias_and_drag_are_near_the_truth() -> None:
    body, found = torpedo()
    for k, axis in ((0, "surge"), (1, "sway"), (5, "yaw")):
        assert found.vehicle.mass[axis, axis].value == pytest.approx(body.mass[k, k], rel=0.1)
        speed = 0.7 * float(found.vehicle.fastest[k])
        terms = {term.name: p.value for term, p in found.vehicle.terms.items() if term.axis == axis}
        drag = terms["linear"] * speed + terms["quadratic"] * speed**2
        assert drag == pytest.approx(body.linear[k] * speed + body.quadratic[k] * speed**2, rel=0.15)


def test_unseen_dives_are_predicted_with_all_axes_at_once() -> None:
    _, found = torpedo()
    model, hold, _ = found.errors.horizons[5.0]
    assert np.all(model < 0.25 * hold)
    assert np.all(found.errors.free_run < 0.3 * found.errors.zero)
    assert found.errors.track[5.0] < 0.5
    assert set(found.refusals) == {"heave", "roll", "pitch"}


def test_a_vehicle_that_nothing_drives_is_refused_with_the_cure() -> None:
    _, log = dive("torpedo", 60.0, 43)
    motion = on_grid([{name: stream for name, stream in log.items() if "force" not in name and name != "torque"}])
    with pytest.raises(BadInput, match="--column surge_force=NAME"):
        identify(motion)


@pytest.mark.parametrize("seconds", [20.0, 60.0])
def test_too_short_a_dive_is_refused_without_a_length_that_moves(seconds: float) -> None:
    """A longer dive shows slower motion and needs longer windows: a figure would grow with the dive that follows it."""
    _, log = dive("torpedo", seconds, 44)
    motion = on_grid([log])
    with pytest.raises(BadInput, match="give longer or more recordings") as refused:
        identify(motion)
    assert re.findall(r"[\d.]+ s\b", str(refused.value)) == [f"{motion.seconds:.3g} s"]


def test_a_dive_of_a_second_is_refused_without_a_length_that_moves() -> None:
    _, log = dive("torpedo", 1.0, 44)
    with pytest.raises(BadInput, match="give longer recordings") as refused:
        on_grid([log])
    assert not re.findall(r"\d", str(refused.value))


def fitted(slope: Array, measured: Array) -> Fit:
    """The fit of one parameter to numbers (windows,) that are the slope times it, under Student's t."""
    parameter, variance = 0.0, np.ones(1)
    for _ in range(60):
        error = (slope * parameter - measured)[:, None, None]
        weight = student_weight(error, variance)
        parameter -= float(np.sum(slope * error[:, 0, 0] * weight[:, 0]) / np.sum(slope**2 * weight[:, 0]))
    error = (slope * parameter - measured)[:, None, None]
    return Fit(
        Structure((), (), (), (), np.zeros((6, 6))), np.array([parameter]), np.ones(1), variance, error,
        slope[None, :, None, None], student_weight(error, variance),
    )  # fmt: skip


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    rng, repeats, held = np.random.default_rng(611), 600, 0
    free = (np.array([-np.inf]), np.array([np.inf]))
    for _ in range(repeats):
        slope = rng.standard_normal(120)
        low, high = intervals(fitted(slope, 0.7 * slope + rng.standard_normal(120)), free)
        held += bool(low[0] <= 0.7 <= high[0])
    assert 0.925 < held / repeats < 0.98
