"""What a model may lack: rows of effects, stages of an effort, delays and inertias, each with a start of its fit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from incsvr.model.rows import Row
from incsvr.model.series import effort_of, values
from incsvr.model.structure import NO_PRIOR, Structure
from incsvr.model.windows import Windows


@dataclass(frozen=True)
class Candidate:
    """Something that a model may lack.

    Attributes:
        name: the effect.
        structure: the model with it.
        own: the parameter that shows whether it is there.
        start: parameters that it brings, and where their fit begins.
        rows: that it adds and that vanish with their coefficients; empty for what is no row.
    """

    name: str
    structure: Structure
    own: str
    start: Mapping[str, float]
    rows: tuple[Row, ...] = ()


def candidates(structure: Structure, effects: Mapping[str, Sequence[Row]], windows: Windows) -> list[Candidate]:
    """Each effect by its rows, stage of an effort, delay and free inertia that the structure does not have."""
    found = list(_of_rows(structure, effects))
    for axis in structure.driven:
        found += _of_stages(structure, axis, windows)
        if structure.shift_priors.get(axis, np.inf) < NO_PRIOR:
            wide = replace(structure, shift_priors={**structure.shift_priors, axis: NO_PRIOR})
            found.append(Candidate(f"delay@{axis}", wide, f"shift:{axis}", {}))
        if axis in structure.given:
            mass = f"mass:{axis}"
            found.append(Candidate(f"inertia@{axis}", structure.plus(free=[axis]), mass, {mass: structure.given[axis]}))
    return found


def of_estimator(structure: Structure, base: Structure) -> Structure:
    """A structure as a base is estimated: by prediction or not, with its average over a measured effort's noise."""
    blurs = tuple(stage for stage in base.stages if stage[0] == "blur" and stage not in structure.stages)
    return replace(structure, predictor=base.predictor, stages=structure.stages + blurs)


def rank(name: str) -> int:
    """The order in which equal effects are preferred: 0 first, then those that can imitate many others."""
    kind = name.partition("@")[0].partition(":")[0]
    if kind in ("memory", "drag_step", "thrust_step"):
        return 2
    return 1 if kind in ("coulomb_asymmetry", "modulation") else 0


def _of_rows(structure: Structure, effects: Mapping[str, Sequence[Row]]) -> Iterator[Candidate]:
    """Effects whose first row the structure does not have; one with a memory once for each start of its lag."""
    have = {row.key for row in structure.rows}
    for effect, rows in effects.items():
        new = tuple(row for row in rows if row.key not in have)
        if not new or new[0] is not rows[0]:
            continue
        own, more, start = new[0].key, structure.plus(rows=new), {row.key: 0.0 for row in new}
        name = effect if "@" in effect else f"{effect}@{new[0].axis}"
        if not new[0].lags:
            yield Candidate(name, more, own, start, new)
        for lag in new[0].lags:
            yield Candidate(name, more, own, {**start, f"time:{own}": float(np.log(lag))})


def _of_stages(structure: Structure, axis: str, windows: Windows) -> Iterator[Candidate]:
    """Stages that the effort of an axis does not pass yet; thrust astern only where both directions were used."""
    top = windows.largest(effort_of(axis))
    effort = values(windows.runs, effort_of(axis))
    starts = {
        "lag": [np.log(2.0 * windows.step)],
        "dead": [np.log(0.05 * top), np.log(0.2 * top)],
        "limit": [np.log(0.8 * top), np.log(0.5 * top)],
        "exponent": [0.2, -0.2],
    }
    if np.quantile(effort, 0.05) < -0.05 * top and np.quantile(effort, 0.95) > 0.05 * top:
        starts["reverse"] = [0.0]
    for kind, each in starts.items():
        if (kind, axis) not in structure.stages:
            more = structure.plus(stages=[(kind, axis)])
            for at in each:
                yield Candidate(f"{kind}@{axis}", more, f"{kind}:{axis}", {f"{kind}:{axis}": float(at)})
