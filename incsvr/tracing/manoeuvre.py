"""The shortest manoeuvre that distinguishes two explanations, found by simulating it under both.

The found model moves without noise; the alternative explains that motion as well as it can, all its numbers free. What
it leaves, in the recordings' own errors, is the evidence to expect (the noncentrality of the likelihood ratio;
F. Pukelsheim, Optimal Design of Experiments, 2006, ch. 1).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from incsvr.effects import Signals
from incsvr.numerics import Array
from incsvr.plant.words import AxisWords
from incsvr.tracing import windows
from incsvr.tracing.cells import cut, plain
from incsvr.tracing.dynamics import Dynamics, Windows
from incsvr.tracing.errors import Colour, Problem, motion_model, pieces_of
from incsvr.tracing.fit import fit
from incsvr.tracing.run import Run
from incsvr.tracing.search import FittedHypothesis
from incsvr.tracing.thresholds import (
    ENOUGH_EVIDENCE,
    MANOEUVRE_SCALES,
    MAX_MANOEUVRE_RATE,
    NO_EVIDENCE,
    STAIR_TORQUE_SHARES,
    USUAL_QUANTILES,
)
from incsvr.tracing.torque_nature import TorqueNature

Rows = tuple[tuple[float, float], ...]
"""A manoeuvre as a vehicle plays it: from when [s] which torque [N m] is asked, until the next row."""


@dataclass(frozen=True, slots=True)
class Manoeuvre:
    """A command in yaw: what to drive, in words, and the torque (n,) [N m] on the gyro's grid."""

    words: str
    torque: Array

    def rows(self, step: float) -> Rows:
        """The times of change [s] and the torque from then on [N m]; the last torque is zero."""
        changes = np.flatnonzero(np.diff(self.torque, prepend=np.nan) != 0.0)
        found = [(round(float(k * step), 4), round(float(self.torque[k]), 4)) for k in changes]
        return (*found, (round(float(self.torque.size * step), 4), 0.0))


def separate(problem: Problem, found: FittedHypothesis, k: int, alternative: FittedHypothesis) -> tuple[str, Rows]:
    """A sentence with the shortest manoeuvre that tells the k-th effect of `found` from that of `alternative`, or that
    there is none; its rows."""
    other, step = alternative.hypothesis.parts[-1].name, problem.cells.resolution
    if float(np.ptp(problem.cells.signals.torque)) == 0.0:
        return f"to distinguish it from {other}, let the thrusters turn the vehicle: here they were off", ()
    most, best = 0.0, Manoeuvre("", np.empty(0))
    for manoeuvre in manoeuvres(problem):
        expected = _evidence(problem, found, alternative, manoeuvre)
        if expected >= ENOUGH_EVIDENCE:
            read = sorted(
                {c for p in (*found.hypothesis.parts, *alternative.hypothesis.parts) for c in p.effect.channels}
            )
            beside = f" while {', '.join(read)} sweeps its range" if read else ""
            words = f"{manoeuvre.words}{beside}: expected evidence 2Δℓ ≈ {2 * expected:.0f}"
            return f"to distinguish it from {other}, drive {words}", manoeuvre.rows(step)
        if expected > most:
            most, best = expected, manoeuvre
    if most < NO_EVIDENCE:
        return hopeless(found.hypothesis.parts[k].name, (other,), problem.cells.signals.words), ()
    words = f"{best.words}, several times: expected evidence 2Δℓ ≈ {2 * most:.1f} each"
    return f"to distinguish it from {other}, drive {words}", best.rows(step)


def hopeless(effect: str, others: Sequence[str], words: AxisWords) -> str:
    """The sentence that no manoeuvre tells an effect from the first of these; empty where there is none.

    No bollard pull measures what a recorded channel does: where either reads one, the advice is of that channel.
    """
    if not others:
        return ""
    alike = f"no manoeuvre in {words.name} distinguishes it from {others[0]}: both explain every motion alike"
    channel = next((name.partition(":")[2] for name in (others[0], effect) if ":" in name), None)
    if channel is None:
        return f"{alike}; measure one of the two by other means (a bollard pull, a pendulum test)"
    return (
        f"{alike}; record a run in which {channel} has other values at the same torques (another place, heading, depth "
        f"or speed), or leave {channel} out if it is a raw sensor's"
    )


def manoeuvres(problem: Problem) -> Iterator[Manoeuvre]:
    """Candidates within the torque that the recordings held, shortest first."""
    s, step = problem.cells.signals, problem.cells.resolution
    top, unit = float(np.quantile(np.abs(s.torque), USUAL_QUANTILES[1])), s.words.effort_unit
    for scales in MANOEUVRE_SCALES:
        length = scales * s.scale
        t = np.arange(0.0, length, step)
        for period in (2.0 * s.scale, 8.0 * s.scale):
            turning = np.where(np.mod(t, period) < 0.5 * period, 1.0, -1.0)
            words = f"steps between ±{top:.3g} {unit} every {0.5 * period:.3g} s for {length:.0f} s"
            yield Manoeuvre(words, top * turning)
        hold = length / len(STAIR_TORQUE_SHARES)
        words = f"stairs of 25, 50, 75 and 100 % of {top:.3g} {unit} both ways, with rests, {hold:.3g} s each"
        yield Manoeuvre(
            words, top * np.array(STAIR_TORQUE_SHARES)[np.minimum((t / hold).astype(int), len(STAIR_TORQUE_SHARES) - 1)]
        )
        sweep = 0.5 * t**2 / length * (1.95 / s.scale) + 0.05 / s.scale * t
        words = (
            f"a sweep of {top:.3g} {unit} from {20.0 * s.scale:.3g} s to {0.5 * s.scale:.3g} s period in {length:.0f} s"
        )
        yield Manoeuvre(words, top * np.sin(2.0 * np.pi * sweep))


def _evidence(problem: Problem, found: FittedHypothesis, alternative: FittedHypothesis, manoeuvre: Manoeuvre) -> float:
    run = _driven(problem, found, manoeuvre)
    if float(np.max(np.abs(run.yaw_rate))) > MAX_MANOEUVRE_RATE * float(np.max(np.abs(problem.cells.signals.rate))):
        return 0.0
    s = problem.cells.signals
    how = replace(windows.cutting([run], s.inertia, TorqueNature(held=True, noisy=False)), scale=s.scale)
    cells = cut([run], s.inertia, sorted(run.channels), how)
    spans = Windows.tiled(pieces_of(cells), how.steps)
    if not spans.first.size:
        return 0.0
    cells = replace(cells, signals=replace(cells.signals, origin=s.origin), fine=replace(cells.fine, origin=s.origin))
    sigma = found.fitted.sigma if not problem.of_innovations else _sigma_ahead(problem, found)
    driven = replace(problem, cells=cells, windows=spans, colour=Colour(), ahead=None)
    missed, own = (_left(driven, each) for each in (alternative, found))
    return max(missed - 1.5 * own, 0.0) / (2.0 * sigma**2)  # what its own model leaves is the error of integration


def _sigma_ahead(problem: Problem, found: FittedHypothesis) -> float:
    """Deviation of the errors a time scale ahead [rad/s]."""
    errors, _ = problem.errors(found.hypothesis, problem.ahead)
    return float(np.sqrt(np.median(np.mean(errors**2, axis=0))))


def _left(problem: Problem, tried: FittedHypothesis) -> float:
    """Squared errors of windows that a hypothesis leaves of a noiseless motion, all its numbers free [rad²/s²]."""
    fitted = fit(problem, tried.hypothesis, Colour(), rounds=4)
    return float(np.sum(np.mean(fitted.errors**2, axis=0)))


def _driven(problem: Problem, found: FittedHypothesis, manoeuvre: Manoeuvre) -> Run:
    """The manoeuvre as the found model drives it, the channels going up and down their range."""
    s, step, n = problem.cells.signals, problem.cells.resolution, manoeuvre.torque.size
    channels = {}
    for k, (name, values) in enumerate(sorted(s.channels.items())):
        low, high = (float(q) for q in np.quantile(values, USUAL_QUANTILES))
        phase = 2.0 * np.pi * np.arange(n) / n * (1.37 + 0.61 * k)
        channels[name] = 0.5 * (low + high) + 0.5 * (high - low) * np.sin(phase)
    time: Array = s.origin[1] + step * np.arange(n, dtype=np.float64)
    still = np.zeros(n)
    grid = Signals(
        step=step, start=np.array([0, n], dtype=np.intp), time=time, rate=still, heading=still, torque=manoeuvre.torque,
        channels=channels, inertia=s.inertia, scale=s.scale, block=step, origin=s.origin, rate_name=s.rate_name,
    )  # fmt: skip
    model = motion_model(problem.cells, found.hypothesis)
    course = Dynamics(plain(grid), model).simulate(Windows.of([slice(0, n)]))
    heading = course.heading[:n, 0]
    return Run(
        manoeuvre.words, time, course.rate[:n, 0], manoeuvre.torque, {**channels, "heading": heading}, s.rate_name
    )
