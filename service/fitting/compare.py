"""`compare`: the dives of one vehicle, and what changed between them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from incsvr.learning.coefficients import NORMAL_95_DEVIATIONS
from incsvr.vehicle import compare as compare_dives
from incsvr.vehicle.causes import causes
from incsvr.vehicle.compare import Comparison, Value
from incsvr.vehicle.model import ASSUMED
from service.cli.extras import plots
from service.cli.next_command import LOG_FLAGS, with_next
from service.fitting.each_log import refuse_dives
from service.fitting.good_enough import MAX_CHANGE_SHARE, Use, good_enough, good_enough_lines, noticing, unknown
from service.fitting.identify import body_reading, configured
from service.fitting.request import Request, read_body
from service.fitting.results import frame
from service.logs.cutting import MIN_STAMP_SINCE_1970_S
from service.recordings.log_refusals import (
    DIVE_GIVEN_TWICE,
    beside_assumptions,
    notes_of,
    refuse_twice,
)
from service.recordings.recording import Recording


@dataclass(frozen=True, slots=True, repr=False)
class Dives:
    """The result of `compare`; `str` is the text that the command prints.

    Attributes:
        compared: every quantity of every dive, and which changed.
        request: what was asked.
    """

    compared: Comparison
    request: Request

    def to_dict(self) -> dict[str, Any]:
        """The JSON that the command writes with `--json`."""
        compared = self.compared
        return {
            "rows": compared.rows(),
            "order": compared.order,
            "shown": [each.to_dict() for each in compared.shown],
            "vehicle": compared.identified.vehicle.to_dict(),
            "explanations": explanations(compared),
            "good_enough": good_enough([_noticed(compared)]),
            "next": self.next[0],
        }

    def __repr__(self) -> str:
        return with_next(text(self.compared), *self.next)

    @property
    def next(self) -> tuple[str | None, str]:
        """The command that follows, if one does, and what it does."""
        compared, dives = self.compared, self.request.recordings
        last = max((compared.dives.index(dive) for dive, _, _ in compared.changes), default=0)
        named = {each.name: each for each in dives}
        logs = tuple(named[dive] for dive in compared.dives[last:] if dive in named) or dives
        why = (
            "identifies the vehicle as it is since the last change" if last else "identifies the vehicle from all dives"
        )
        return self.request.following("identify", (*LOG_FLAGS, "set"), "--write", "vehicle.yaml", files=logs), why

    def plot(self) -> Any:
        """Inertia and drag of every axis over the dives, with intervals, as a figure of matplotlib."""
        return plots().of_comparison(self.compared)

    def to_frame(self) -> Any:
        """One row for each dive and quantity, as a DataFrame of pandas."""
        return frame(self.compared.rows())


def compare(request: Request) -> Dives:
    """Compares the dives of one vehicle.

    Raises:
        BadInput: a log cannot be used, or what is said of them; one sentence with the cure.
    """
    config, masses = configured(request)
    reading = body_reading(request, config)
    recordings = [read_body(reading, [each])[0] for each in request.recordings]
    refuse_twice(recordings, DIVE_GIVEN_TWICE)
    recordings, order = _in_order(recordings)
    with beside_assumptions(notes_of(recordings)):
        refuse_dives(recordings)
    streams = [recording.own_streams for recording in recordings]
    compared = compare_dives(streams, [recording.name for recording in recordings], masses)
    return Dives(replace(compared, order=order), request)


def _noticed(compared: Comparison) -> Use:
    """The verdict on the drag whose smallest change shows."""
    shares = {each.what: each.change / abs(each.reference) for each in compared.shown if each.change and each.reference}
    drags = {name: share for name, share in shares.items() if " drag" in name}
    if not drags:
        return unknown(
            "noticing a change", MAX_CHANGE_SHARE, "these dives determine no drag; record steps of each effort"
        )
    best = min(drags, key=lambda name: drags[name])
    return noticing(drags[best], best)


def _in_order(recordings: list[Recording]) -> tuple[list[Recording], str]:
    """The dives in the order of their stamps, where all stamps are dates, else as given; and that order in words."""
    undated = next((each.name for each in recordings if each.time[0] < MIN_STAMP_SINCE_1970_S), None)
    if undated is not None:
        return recordings, f"in the order in which they were given, because {undated} has no date"
    ordered = sorted(recordings, key=lambda each: float(each.time[0]))
    given = (
        ""
        if all(a is b for a, b in zip(ordered, recordings, strict=True))
        else ", which is not the order in which they were given"
    )
    return ordered, f"in the order of their stamps{given}"


def explanations(compared: Comparison) -> dict[str, list[str]]:
    """Dive → the single causes that fit what changed in it, the likeliest first; empty where none does."""
    changed = dict.fromkeys(dive for dive, _, _ in compared.changes)
    return {dive: [cause.what for cause in causes(compared, compared.dives.index(dive))] for dive in changed}


def text(compared: Comparison) -> str:
    """The comparison for people: one table a quantity, and the changes."""
    lines = []
    for quantity, row in zip(compared.quantities, compared.values, strict=True):
        own = compared.identified.vehicle.mass.get((quantity.axis, quantity.axis))
        scale = "; its inertia is assumed, so only ratios count" if own is not None and own.origin == ASSUMED else ""
        lines.append(f"{quantity.name} [{quantity.unit}]{scale}")
        for dive, value in zip(compared.dives, row, strict=True):
            lines.append(value_line(dive, value))
    lines.append("")
    changes = compared.changes
    for dive, quantity, value in changes:
        lines.append(f"{dive}: {quantity.axis} {quantity.kind} {change_words(value)}")
    for dive, found in explanations(compared).items():
        fits = "; or ".join(found) if found else "no single cause that was tested fits all inertias and drags"
        lines.append(f"{dive}: {fits}")
    if not changes:
        lines.append("no change proven")
    lines += [each.sentence for each in compared.shown]
    lines.append(f"The dives are {compared.order}.")
    lines.append(f"The chance of any false change over these {len(compared.dives)} dives is at most 5 %.")
    lines += ["", *good_enough_lines([_noticed(compared)])]
    return "\n".join(lines)


def value_line(dive: str, value: Value) -> str:
    """A dive's value with its interval, beside that of the dives before."""
    against = ""
    if value.reference is not None:
        against = f"  before {value.reference:.4g}, p = {value.p_value:.2g}, least change {value.smallest:.2g}"
    mark = "  CHANGED" if value.changed else ""
    return f"  {dive:<24}{value.estimate:>10.4g} ({value.low:.4g} to {value.high:.4g}){against}{mark}"


def change_words(value: Value) -> str:
    """By how much a value changed against the dives before, with an interval of 95 %, and how sure that is."""
    before, before_error = value.reference or 0.0, value.reference_error or 0.0
    certainty = f"p = {value.p_value:.1g}"
    if not before or value.estimate / before <= 0.0:
        return f"changed from {before:.4g} to {value.estimate:.4g} from this dive on ({certainty})"
    ratio = value.estimate / before
    spread = math.hypot(value.error / value.estimate, before_error / before)
    ends = (ratio * math.exp(side * NORMAL_95_DEVIATIONS * spread) for side in (0.0, -1.0, 1.0))
    by, low, high = (f"{100.0 * (each - 1.0):+.0f}" for each in ends)
    return f"changed by {by} % from this dive on (95 %: {low} to {high} %; {certainty})"
