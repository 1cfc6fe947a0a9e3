"""The texts of the pages, as Markdown; the figures that matter from two metres stand on top, large."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from incsvr.compensation.proof import errors
from incsvr.plant.words import YAW_WORDS, AxisWords
from incsvr.tracing.sentences import chance
from service.wire import EffectsLedger, Health
from viewer.frame import Frame
from viewer.names import about, clock_text, effect, step

LEVELS = {"OK": "OK", "WARN": "WARNING", "ERROR": "ERROR", "STALE": "NO DATA"}


def iteration(frame: Frame, axis: AxisWords = YAW_WORDS) -> str:
    """One iteration, with its figures."""
    report = frame.report
    untried = report.progressive_mae is None
    headline = "first model" if untried else f"error {quantity(report.progressive_mae, axis.effort_unit)}"
    notes = []
    if not report.trained:
        notes.append("**Nothing new in this batch: the model stays as it was.**")
    if report.change:
        notes.append(f"**{report.change[:1].upper()}{report.change[1:]}**")
    if frame.snapshot is None:
        notes.append("**The learner no longer has this revision's model: the curve is missing.**")
    lines = [
        f"# Iteration {report.iteration}  ·  {headline}",
        f"{report.counts.get('batch', 0)} samples, vehicle time {clock_text(report.time_span[0])} to "
        f"{clock_text(report.time_span[1])}, revision {report.revision}",
        *("\n" + note for note in notes),
        "",
        *table(("Learning", "Value"), _figures(frame, axis).items()),
    ]
    return "\n".join(lines)


def samples(frame: Frame, sets: Mapping[str, str]) -> str:
    """How many samples are in each set that the page draws, by what the legend calls it."""
    rows = [(text, len(getattr(frame.report, name))) for name, text in sets.items()]
    undriven = ("Driven by the water", frame.report.counts.get("undriven", 0))
    return "\n".join(table(("Samples", "Count"), [*rows, undriven]))


def compared(before: Frame, after: Frame, axis: AxisWords = YAW_WORDS) -> str:
    """Two revisions side by side."""
    assert after.model is not None
    rate, damping = before.curve.T
    apart = np.abs(after.model.predict(rate).damping - damping)
    columns = [
        {
            "Revision": str(each.report.revision),
            "Vehicle time": clock_text(each.report.t),
            "Support vectors": str(len(each.report.support)),
            **_figures(each, axis),
        }
        for each in (before, after)
    ]
    rows = [(name, value, columns[1][name]) for name, value in columns[0].items() if name in columns[1]]
    unit = axis.effort_unit
    lines = [
        f"# Iteration {before.report.iteration} and {after.report.iteration}",
        f"Difference {quantity(apart.max(), unit)} at most, {quantity(apart.mean(), unit)} on average, where the first "
        "was trained.\n",
        *table(("", "Before", "After"), rows),
    ]
    return "\n".join(lines)


def _figures(frame: Frame, axis: AxisWords) -> dict[str, str]:
    """What an iteration is judged by, in words."""
    report, model, unit = frame.report, frame.model, axis.effort_unit
    span = None if frame.snapshot is None else frame.snapshot.model.trained_range
    return {
        "Training time": f"{report.training_ms:.1f} ms",
        "Error before learning": quantity(report.progressive_mae, unit),
        **{f"Error on {check.name}": quantity(check.mae, unit) for check in report.validation},
        "Noise of a sample": quantity(report.noise, unit),
        "Tube of no penalty": "-" if model is None else f"±{quantity(model.epsilon, unit)}",
        "Off the optimum at most": quantity(report.certified_error, unit),
        "Trained from": "-" if span is None else f"{span[0]:.3g} to {span[1]:.3g} {axis.rate_unit}",
    }


def health(said: Health, axis: AxisWords = YAW_WORDS) -> str:
    """The level large, then why, then every counter."""
    streams = [
        (name, one.received, one.lost, "-" if one.t is None else clock_text(one.t))
        for name, one in sorted(said.streams.items())
    ]
    counters = [(name.replace("_", " ").replace(":", ": "), count) for name, count in sorted(said.counters.items())]
    lines = [
        f"# {LEVELS[said.level]}",
        *(f"- {reason[:1].upper()}{reason[1:]}." for reason in said.reasons),
        "" if said.reasons else "Nothing to report.",
        f"\n**Learned: {100 * said.learned:.0f} % of the {axis.rate} range** · iteration {said.iteration} · "
        f"revision {said.revision} · boot {said.boot}\n",
        *table(("Stream", "Samples", "Lost", "Newest"), streams),
        "",
        *table(("Counter", "Since start"), counters),
    ]
    return "\n".join(lines)


def ledger(said: EffectsLedger, axis: AxisWords = YAW_WORDS) -> str:
    """The effects in force and those that are not, then every step that led there."""
    lines = ["# Traced effects", ""]
    if said.found and not said.effects:
        lines.append("None is in force. `incsvr effects promote NAME` puts in force what was found.")
    elif not said.effects:
        lines.append(
            f"None: the model is the declared {axis.inertia} and the learned damping.\n\n`incsvr trace RECORDING… "
            "--json FILE` finds effects that it lacks. With `effects: FILE` in its configuration the learner applies "
            "them; with `tracing.live: advise` or `adopt` it finds them by itself. The plots show the parts of "
            f"every {axis.effort}, once an effect is in force."
        )
    for each in said.effects:
        lines += _about(each, axis)
    if said.found:
        lines.append("\n# Found, not in force")
    for each in said.found:
        lines += _about(each, axis)
    if said.history:
        lines += ["\n## Ledger", *(f"- {step(entry)}" for entry in said.history[-30:])]
    return "\n".join(lines)


def _about(found: dict[str, Any], axis: AxisWords) -> list[str]:
    """An effect: what it is with its values and intervals, how sure, and its errors where they are known."""
    state, said = found.get("state"), about(found)
    name = effect(str(found.get("effect", "?")))
    lines = [f"## {name} ({state})" if state else f"## {name}", said[:1].upper() + said[1:]]
    if found.get("p_value") is not None:
        lines.append(f"- p {chance(found['p_value'], 1)}")
    if found.get("error"):
        lines.append(f"- On fresh data, without → with it: {errors(found['error'], axis)}")
    return lines


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> list[str]:
    """The lines of a table whose first column is text."""
    lines = [head, [":--", *["--:"] * (len(head) - 1)], *rows]
    return [f"| {' | '.join(map(str, line))} |" for line in lines]


def quantity(value: float | None, unit: str) -> str:
    """Three figures and the unit, never as a power of ten: 0.0000849 N m."""
    if value is None:
        return "-"
    return f"{np.format_float_positional(value, precision=3, fractional=False, trim='-')} {unit}"
