"""What a model may lack: rows of effects, stages of an effort, delays and inertias, each with a start of its fit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from incsvr.model.rows import Row
from incsvr.model.series import effort_of, period, values
from incsvr.model.structure import NO_PRIOR, Structure, Theta
from incsvr.model.windows import Windows

CURVE = "bend:"
"""The begin of the names of what is another curve of damping."""
SHAPES = {"dead": "gap", "gap": "dead", "limit": "sag", "sag": "limit", "lag": "spin", "spin": "lag"}
"""Stages that are one effect in two shapes, of which one acts at most."""


@dataclass(frozen=True)
class Candidate:
    """Something that a model may lack, at one of the places where the fit of it may begin.

    Attributes:
        name: the effect.
        structure: the model with it.
        start: parameters that it brings, and where their fit begins.
        rows: that it adds and that vanish with their coefficients; empty for what is no such row.
        one_sided: whether only the direction from nothing to `start` makes sense.
    """

    name: str
    structure: Structure
    start: Mapping[str, float]
    rows: tuple[Row, ...] = ()
    one_sided: bool = False


def candidates(
    structure: Structure, theta: Theta, effects: Mapping[str, Sequence[Row]], windows: Windows
) -> list[Candidate]:
    """Each effect by its rows, stage of an effort, delay, free and coupled inertia that the structure does not have."""
    found = list(_of_rows(structure, effects))
    for axis in structure.driven:
        found += _of_stages(structure, axis, windows)
        if structure.shift_priors.get(axis, np.inf) < NO_PRIOR:
            wide = replace(structure, shift_priors={**structure.shift_priors, axis: NO_PRIOR})
            beat = period(windows.runs, effort_of(axis))
            found += [
                Candidate(f"delay@{axis}", wide, {f"shift:{axis}": beats * beat}, one_sided=True)
                for beats in (2.0, 5.0, -3.0)
            ]
        if axis in structure.given:
            start = {f"mass:{axis}": structure.given[axis] + 0.05}
            found.append(Candidate(f"inertia@{axis}", structure.plus(free=[axis]), start))
    return found


def coupled_pairs(axes: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """Entries of M off its diagonal that a body whose port mirrors its starboard may have (Fossen 2011, Eq. 7.22)."""
    groups = (("surge", "heave", "pitch_rate"), ("sway", "roll_rate", "yaw_rate"))
    return tuple(pair for group in groups for pair in combinations(group, 2) if set(pair) <= set(axes))


def joined(structure: Structure, candidate: Candidate) -> Structure:
    """A structure with what a candidate brings to its own."""
    own, brought = candidate.structure, set(candidate.start)
    free = {name.partition(":")[2] for name in brought if name.startswith("mass:")}
    return replace(
        structure,
        rows=structure.rows + tuple(row for row in own.rows if row.key in brought),
        coupled=structure.coupled + tuple((a, b) for a, b in own.coupled if f"mass:{a}*{b}" in brought),
        stages=structure.stages + tuple((kind, axis) for kind, axis in own.stages if f"{kind}:{axis}" in brought),
        given={axis: value for axis, value in structure.given.items() if axis not in free},
        shift_priors={
            **structure.shift_priors,
            **{axis: value for axis, value in own.shift_priors.items() if f"shift:{axis}" in brought},
        },
    )


def without(structure: Structure, candidate: Candidate, plain: Structure) -> Structure:
    """A structure without what a candidate had brought, as the plain one has it."""
    brought = set(candidate.start)
    axes = {name.partition(":")[2] for name in brought}
    return replace(
        structure,
        rows=tuple(row for row in structure.rows if row.key not in brought),
        coupled=tuple((a, b) for a, b in structure.coupled if f"mass:{a}*{b}" not in brought),
        stages=tuple((kind, axis) for kind, axis in structure.stages if f"{kind}:{axis}" not in brought),
        given={**structure.given, **{a: v for a, v in plain.given.items() if a in axes and f"mass:{a}" in brought}},
        shift_priors={
            **structure.shift_priors,
            **{a: v for a, v in plain.shift_priors.items() if f"shift:{a}" in brought},
        },
    )


def of_curve(candidate: Candidate) -> bool:
    """Whether it is another curve of damping, which is learned and no effect."""
    return candidate.name.startswith(CURVE)


def other_shape(name: str) -> str:
    """The name of a dead band or a limit in its other shape; of anything else empty."""
    kind, _, axis = name.partition("@")
    return f"{SHAPES[kind]}@{axis}" if kind in SHAPES else ""


def scales_thrust(name: str) -> bool:
    """Whether an effect changes what an effort does, so that an effort that is mostly noise cannot show it."""
    kind = name.partition("@")[0]
    stages = ("inertia", "dead", "gap", "exponent", "limit", "sag", "reverse", "inflow", "lag", "spin", "delay")
    return kind in stages or kind.startswith("thrust_") or kind.endswith(":thrust")


def rank(candidate: Candidate) -> tuple[int, int, int]:
    """The order in which equal effects are preferred: a curve of damping, which is none, then those that imitate few
    others, of few numbers, of no channel."""
    name, _, axis = candidate.name.partition("@")
    kind, _, of = name.partition(":")
    if of_curve(candidate):
        return -1, 0, 0
    late = kind in ("coulomb_asymmetry", "modulation") or (kind == "coriolis" and axis in of.split("*"))
    return 2 if imitates(candidate) else int(late), len(candidate.start), int(bool(of))


def imitates(candidate: Candidate) -> bool:
    """Whether an effect can imitate many others."""
    return candidate.name.partition("@")[0].partition(":")[0] in ("memory", "drag_step", "thrust_step", "gyro_bias")


def _of_rows(structure: Structure, effects: Mapping[str, Sequence[Row]]) -> Iterator[Candidate]:
    """Effects whose first row the structure does not have; one with a memory once for each start of its lag."""
    have = {row.key for row in structure.rows}
    for effect, rows in effects.items():
        new = tuple(row for row in rows if row.key not in have)
        if not new or new[0] is not rows[0]:
            continue
        own, more = new[0].key, structure.plus(rows=new)
        name = effect if "@" in effect else f"{effect}@{new[0].axis}"
        if not new[0].lags:
            yield Candidate(name, more, {row.key: 0.0 for row in new}, new)
        for lag in new[0].lags:
            yield Candidate(name, more, {own: 0.0, f"time:{own}": float(np.log(lag))})


def _of_stages(structure: Structure, axis: str, windows: Windows) -> Iterator[Candidate]:
    """Stages that the effort of an axis does not pass yet; thrust astern only where both directions were used."""
    top = windows.largest(effort_of(axis))
    effort = values(windows.runs, effort_of(axis))
    beat = period(windows.runs, axis)
    starts: dict[str, Sequence[float]] = {
        "lag": [np.log(beats * beat) for beats in (0.5, 1.0, 2.0, 4.0)],
        "spin": [np.log(beats * beat) for beats in (0.5, 1.0, 2.0, 4.0)],
        "dead": [np.log(share * top) for share in (0.03, 0.1, 0.3)],
        "gap": [np.log(share * top) for share in (0.1, 0.2, 0.4)],
        "limit": [np.log(share * top) for share in (0.9, 0.7, 0.5)],
        "sag": [np.log(share * top) for share in (2.0, 1.0, 0.6)],
        "exponent": [0.1],
    }
    if np.quantile(effort, 0.01) < -0.05 * top and np.quantile(effort, 0.99) > 0.05 * top:
        starts["reverse"] = [0.1]
    have = {kind for kind, of in structure.stages if of == axis}
    have |= {SHAPES[kind] for kind in have if kind in SHAPES}
    for kind, each in starts.items():
        if kind not in have:
            more = structure.plus(stages=[(kind, axis)])
            for at in each:
                one_sided = kind in ("lag", "spin", "dead", "gap", "limit", "sag")
                yield Candidate(f"{kind}@{axis}", more, {f"{kind}:{axis}": float(at)}, one_sided=one_sided)
