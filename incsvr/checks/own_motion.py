"""The motion of one log against its efforts, by a least squares of its own: gain, delay, the hands of its axes.

Streams are filtered alike with a short bell, and of one axis τ(t − δ) = m ν̇ + a ν + b ν|ν| + c is fitted beside
products of velocities, the other accelerations and the angle that rights the vehicle.
No engine of the whole vehicle is needed, so that a log is judged before anything is concluded from it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from incsvr.numerics import Array, running_integral
from incsvr.plant.axes import VELOCITIES, Axis
from incsvr.signals.smoothing import smooth

Streams = Mapping[str, tuple[Array, Array]]
PERIODS = 2.0
"""Width of the bell in periods of the slowest stream: a wider one hides a vehicle's fast answer."""
MIN_WIDTH_S = 0.05
"""The narrowest bell [s]."""
DELAYS_S: Array = np.arange(-0.3, 0.61, 0.02, dtype=np.float64)
"""Delays of an effort that are tried [s]; it is stamped late where one is negative."""
MIN_INSTANTS, MAX_INSTANTS = 60, 2000
"""Instants from which on a motion says something, and that are looked at."""
CERTAIN_DEVIATIONS = 4.0
"""Standard errors by which a coefficient has its sign."""
RIGHTED_RATES = ("roll_rate", "pitch_rate")
"""Rates whose integral is an angle at which weight and buoyancy turn the vehicle back."""
MIN_EXPLAINED = 0.3
"""Share of an effort that a motion explains at least, to say anything of it."""


@dataclass(frozen=True, slots=True)
class Filtered:
    """Streams at common instants.

    Attributes:
        time: (n,) instants [s].
        value, slope: (n,) each, by the names of recordings.
    """

    time: Array
    value: Mapping[str, Array]
    slope: Mapping[str, Array]

    def joined(self, other: Filtered) -> Filtered:
        """Two logs with the same streams, one after the other."""
        value, slope = (
            {name: np.concatenate((each, b[name])) for name, each in a.items()}
            for a, b in ((self.value, other.value), (self.slope, other.slope))
        )
        return Filtered(np.concatenate((self.time, other.time)), value, slope)


@dataclass(frozen=True, slots=True)
class Fit:
    """A linear least squares.

    Attributes:
        theta, error: (k,) coefficients and their standard errors.
        left: share of the target's variance that it leaves.
    """

    theta: Array
    error: Array
    left: float

    def certain(self, k: int) -> float:
        """The sign of a coefficient where it is certain, else 0."""
        return float(np.sign(self.theta[k])) * float(abs(self.theta[k]) > CERTAIN_DEVIATIONS * self.error[k])


@dataclass(frozen=True, slots=True)
class Response:
    """The answer of one axis to its effort.

    Attributes:
        inertia: effort by acceleration, beside the drag, at `delay`.
        linear, quadratic: of the drag.
        speed: 90 % of the speeds are below it.
        reach: the largest effort.
        delay: by which the effort acts late where the rest fits best [s].
        left: share of the effort's variance that is left, at each of the delays.
        opposed: whether inertia and drag both count against the effort at every delay at which they explain it.
    """

    inertia: float
    linear: float
    quadratic: float
    speed: float
    reach: float
    delay: float
    left: Array
    opposed: bool

    def drag_at(self, speed: float) -> float:
        """The effort that the drag takes at a speed."""
        return self.linear * speed + self.quadratic * speed**2

    def left_at(self, delay: float) -> float:
        """Share that is left at one of the delays [s]."""
        return float(self.left[int(np.argmin(np.abs(DELAYS_S - delay)))])


def filtered(streams: Streams, names: Sequence[str]) -> Filtered | None:
    """The streams at common instants; None where they are too short."""
    found = _instants(streams, names)
    if found is None:
        return None
    at, width = found
    each = {name: smooth(*streams[name], at, smoothing=width, gap=6.0 * width) for name in names}
    known = np.all([np.isfinite(one.value) & np.isfinite(one.slope) for one in each.values()], axis=0)
    if np.count_nonzero(known) < MIN_INSTANTS:
        return None
    return Filtered(
        at[known],
        {name: one.value[known] for name, one in each.items()},
        {name: one.slope[known] for name, one in each.items()},
    )


def _instants(streams: Streams, names: Sequence[str]) -> tuple[Array, float] | None:
    if any(name not in streams or streams[name][0].size < MIN_INSTANTS // 2 for name in names):
        return None
    width = max(PERIODS * max(float(np.median(np.diff(streams[name][0]))) for name in names), MIN_WIDTH_S)
    begin, end = (max(streams[name][0][0] for name in names), min(streams[name][0][-1] for name in names))
    at = np.arange(begin + 3.0 * width + DELAYS_S[-1], end - 3.0 * width + DELAYS_S[0], width)
    return None if at.size < MIN_INSTANTS else (at[:: 1 + at.size // MAX_INSTANTS], width)


def least_squares(target: Array, columns: Sequence[Array]) -> Fit:
    """The fit of a target (n,) by columns (n,) and a constant."""
    design = np.column_stack([*columns, np.ones(target.size)])
    scale = np.maximum(np.linalg.norm(design, axis=0), 1e-300)
    inverse = np.linalg.pinv(design / scale)
    theta = inverse @ target
    left = target - (design / scale) @ theta
    freedom = max(0.5 * target.size - theta.size, 1.0)  # neighbours share half of their windows
    error = np.sqrt(np.sum(inverse**2, axis=1) * float(left @ left) / freedom)
    about = target - np.mean(target)
    return Fit(theta / scale, error / scale, float(left @ left) / max(float(about @ about), 1e-300))


def response(streams: Streams, axis: Axis) -> Response | None:
    """The answer of an axis to its effort; None where nothing can be told."""
    others = [name for name in VELOCITIES if name in streams and name != axis.rate and streams[name][0].size]
    found = _instants(streams, (axis.rate, axis.effort, *others))
    seen = filtered(streams, (axis.rate, axis.effort, *others))
    if found is None or seen is None or np.ptp(seen.value[axis.effort]) == 0.0:
        return None
    own, every = seen.value[axis.rate], [*others, axis.rate]
    products = [seen.value[a] * seen.value[b] for k, a in enumerate(every) for b in every[k + 1 :]]
    columns = [seen.slope[axis.rate], own, own * np.abs(own), *products, *(seen.slope[each] for each in others)]
    if axis.rate in RIGHTED_RATES:
        columns.append(running_integral(seen.time, own - own.mean()))
    width = found[1]
    speed = float(np.quantile(np.abs(own), 0.9))
    dense = np.arange(seen.time[0] - DELAYS_S[-1] - width, seen.time[-1] - DELAYS_S[0] + width, 0.25 * width)
    pushed = smooth(*streams[axis.effort], dense, smoothing=width, gap=6.0 * width).value
    left, signs, fits = [], [], []
    for delay in DELAYS_S.tolist():
        effort = np.interp(seen.time - delay, dense, pushed)
        known = np.isfinite(effort)
        fit = least_squares(effort[known], [each[known] for each in columns])
        drag = float(fit.theta[1] * speed + fit.theta[2] * speed**2)
        fits.append((float(fit.theta[0]), float(fit.theta[1]), float(fit.theta[2])))
        left.append(fit.left)
        signs.append(fit.certain(0) + np.sign(drag) if fit.left < 1.0 - MIN_EXPLAINED else 0.0)
    best = int(np.argmin(left))
    told = 0 < best < DELAYS_S.size - 1  # the best delay at an end means that another effort moves this axis
    opposed = bool(told and min(signs) == -2.0 and max(signs) < 2.0 and signs[best] == -2.0)
    reach = float(np.max(np.abs(streams[axis.effort][1])))
    return Response(*fits[best], speed, reach, float(DELAYS_S[best]), np.array(left), opposed)


@dataclass(frozen=True, slots=True)
class Planar:
    """Surge, sway and yaw together: what rigid-body kinematics asks of their products, and what is left.

    Attributes:
        left: share of the efforts that is left, the mean of the axes.
        hands: +1 where the Coriolis products count as the velocities do, −1 where all count against them, 0 unknown.
        reversed: whether the inertias along are negative.
    """

    left: float
    hands: int
    reversed: bool


def planar(seen: Filtered, lever: tuple[float, float] = (0.0, 0.0), coupled: bool = False) -> Planar:
    """The motion in the plane, with velocities measured at a place ahead and aside [m] of where the efforts act.

    Args:
        coupled: with the inertias by which an offset centre of mass couples the axes, in place of a lever.
    """
    (u, v, r), (du, dv, dr) = (
        (each["surge"] + lever[1] * each["yaw_rate"], each["sway"] - lever[0] * each["yaw_rate"], each["yaw_rate"])
        for each in (seen.value, seen.slope)
    )
    beside = {"surge_force": [r * r, dr], "sway_force": [dr, r * r], "torque": [dv, u * r, du, v * r]}
    own = {"surge_force": (du, v * r, u), "sway_force": (dv, u * r, v), "torque": (dr, u * v, r)}
    fits = {
        name: least_squares(
            seen.value[name], [slope, product, each, each * np.abs(each), *(beside[name] if coupled else ())]
        )
        for name, (slope, product, each) in own.items()
        if name in seen.value and np.ptp(seen.value[name]) > 0.0
    }
    signs = []
    if "surge_force" in fits:
        signs.append(-fits["surge_force"].certain(1) * fits["surge_force"].certain(0))
    if "sway_force" in fits:
        signs.append(fits["sway_force"].certain(1) * fits["sway_force"].certain(0))
    elif fits:  # nothing pushes sideways: the products alone do
        signs.append(-least_squares(dv, [u * r, v, v * np.abs(v)]).certain(0))
    agree = len(signs) == 2 and signs[0] == signs[1]
    along = [fit.theta[0] < 0.0 for name, fit in fits.items() if name != "torque"]
    left = float(np.mean([fit.left for fit in fits.values()])) if fits else 1.0
    return Planar(left, int(signs[0]) if agree else 0, bool(along) and all(along))


def turned(seen: Filtered, heading: Array, swapped: bool, mirrored: bool = False) -> Filtered:
    """Velocities to the north and east (or east and north, `swapped`) turned into the body by a heading (n,) [rad].

    Args:
        mirrored: east counts to the other side than the heading.
    """
    names = ("sway", "surge") if swapped else ("surge", "sway")
    side = -1.0 if mirrored else 1.0
    north, east = seen.value[names[0]], side * seen.value[names[1]]
    rise_north, rise_east = seen.slope[names[0]], side * seen.slope[names[1]]
    cos, sin, rate = np.cos(heading), np.sin(heading), seen.value["yaw_rate"]
    u, v = cos * north + sin * east, cos * east - sin * north
    du, dv = cos * rise_north + sin * rise_east + rate * v, cos * rise_east - sin * rise_north - rate * u
    return replace(seen, value={**seen.value, "surge": u, "sway": v}, slope={**seen.slope, "surge": du, "sway": dv})


FRAMES = (
    ("north_east", False, False),
    ("east_north", True, False),
    ("north_east", False, True),
    ("east_north", True, True),
)
"""Frames of the world: its name, and how `turned` is told of it."""
MIN_FRAME_LEFT = 0.05
"""Share of the efforts that is left at least where velocities may be those of another place or frame."""
MIN_TURN_RAD = 1.0
"""How far a heading turns at least to show a frame [rad]."""
OFFSETS: Array = np.arange(0.0, 2.0 * np.pi, np.pi / 12.0, dtype=np.float64)
"""Headings that are tried at the begin of a log without one [rad]."""


ZERO_STEP, FAR_ZERO = np.pi / 90.0, np.pi / 9.0
"""Step of a frame's heading that is tried about the best of OFFSETS, and the heading from which on one is named [rad]:
compasses err by some degrees."""


def world_frame(seen: Filtered, heading: Array | None, left: float) -> tuple[str, bool, float] | None:
    """The frame of the world in which the velocities are, by its name, whether it is mirrored, and the heading of its
    north [rad], where that is far from zero; None without one.

    Args:
        heading: (n,) [rad]; without, that of the gyro is tried from several beginnings.
        left: what is left by the velocities as they are.
    """
    if heading is not None:
        angles = [heading] if np.ptp(heading) > MIN_TURN_RAD else []
    else:
        turn = np.concatenate(([0.0], np.cumsum(np.diff(seen.time) * seen.value["yaw_rate"][1:])))
        angles = [turn + offset for offset in OFFSETS.tolist()] if np.ptp(turn) > MIN_TURN_RAD else []
    if not angles:
        return None
    seen_in = [
        (each.left, each.reversed, name, mirrored)
        for name, swapped, mirrored in FRAMES[: 2 if heading is None else None]  # any north is tried without a heading
        for each in (planar(turned(seen, angle, swapped, mirrored)) for angle in angles)
    ]
    best, is_reversed, name, mirrored = min(seen_in)
    north = 0.0
    if heading is not None and (best > MIN_FRAME_LEFT or is_reversed):
        best, north, mirrored_too = min(_to_north(seen, heading, turned_over) for turned_over in (False, True))
        if abs(north) > FAR_ZERO:
            name, mirrored = FRAMES[0][0], mirrored_too
    return (name, mirrored, north if abs(north) > FAR_ZERO else 0.0) if best < MIN_BETTER_RATIO * left else None


def _to_north(seen: Filtered, heading: Array, mirrored: bool) -> tuple[float, float, bool]:
    """What is left at the best heading of a frame's north, that heading [rad], and whether the frame is mirrored."""
    tried, north = OFFSETS, 0.0
    for _ in range(2):
        left, north = min((planar(turned(seen, heading - each, False, mirrored)).left, each) for each in tried.tolist())
        tried = north + np.arange(-4, 5) * ZERO_STEP
    if planar(turned(seen, heading - north, False, mirrored)).reversed:
        north += np.pi
    return left, float((north + np.pi) % (2.0 * np.pi) - np.pi), mirrored


MAX_LEVER_M = 3.0
"""The farthest place of a velocity sensor that is looked for [m]."""
MIN_LEVER_M = 0.03
"""The lever from which on one is named [m]."""
MIN_BETTER_RATIO = 0.5
"""What another frame, or a lever, leaves of what was left, at most, to be named."""


def lever(seen: Filtered) -> tuple[float, float] | None:
    """The place ahead and aside [m] at which the velocities are measured, if it explains what is left; else None.

    A centre of mass ahead couples sway with yaw as a lever does, but also yaw with sway: a lever alone is one-sided.
    """
    without = planar(seen).left
    left, place = without, (0.0, 0.0)
    grid = [
        (ahead, aside) for ahead in np.linspace(-MAX_LEVER_M, MAX_LEVER_M, 13) for aside in (-1.0, -0.5, 0.0, 0.5, 1.0)
    ]
    step = 0.5  # of the grid [m]; it is halved until it is a tenth of the lever that is named
    while step > 0.1 * MIN_LEVER_M:
        left, place = min((left, place), *((planar(seen, each).left, each) for each in grid))
        step *= 0.5
        grid = [(place[0] + step * ahead, place[1] + step * aside) for ahead in (-1, 0, 1) for aside in (-1, 0, 1)]
    far = max(abs(each) for each in place)
    if left > MIN_BETTER_RATIO * without or left > planar(seen, coupled=True).left * 1.2:
        return None
    return place if MIN_LEVER_M < far < MAX_LEVER_M else None
