"""The page Effects: what the model holds beside inertia and damping, and how every prediction splits into its parts."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Any

import numpy as np
import rerun as rr
from rerun.components import MarkerShape

from incsvr.compensation.proof import errors
from incsvr.plant.words import YAW_WORDS, AxisWords
from incsvr.tracing.sentences import chance
from service.wire import Batch, EffectsLedger
from viewer.frame import Floats, Frame
from viewer.names import effect, found_title, parameter, step, words
from viewer.palette import LIGHT
from viewer.recorder import Recorder

DAMPING = "damping"


class EffectsPage:
    """Logs below effects/."""

    def __init__(self, rec: Recorder) -> None:
        self._rec = rec
        self._drawn = -inf, -inf  # the vehicle's time of the first and last sample of the newest batch [s]
        rec.dots("effects/torque/measured", LIGHT.old, "Measured", MarkerShape.Circle, 2.0)
        rec.line("effects/torque/predicted", "Predicted", LIGHT.new)
        self._ledger, self._told = EffectsLedger(), False
        self._found: dict[str, tuple[str, str]] = {}  # entity → effect and parameter

    @property
    def found(self) -> Mapping[str, str]:
        """The plots of what was found while no effect is in force: entity → title, with what the ledger calls it."""
        if self._ledger.effects:
            return {}
        states = {str(each.get("effect")): str(each.get("state", "found")) for each in self._ledger.found}
        present_first = sorted(self._found.items(), key=lambda each: each[1][0] not in states)
        return {
            path: found_title(name, states.get(name, "no longer found"), key, self._rec.words)
            for path, (name, key) in present_first
        }

    def say(self, ledger: EffectsLedger) -> None:
        """The ledger, at the clocks that are set."""
        self._ledger, self._told = ledger, False
        self._tell()
        self._draw_found()

    def log(self, frame: Frame) -> None:
        """One iteration's torque and its parts, on the vehicle's time."""
        if not self._told:
            # What was said before the first iteration stands on the clock on the wall alone.
            self._tell()
            self._told = True
        self._draw_found()
        batch = frame.report.batch
        time = np.array(batch.time)
        if not batch.parts:
            return
        # A learner that changes over from some effects to others says its last batch again, split anew; a batch before
        # that one is of a clock that restarted.
        new = (time > self._drawn[1]) | (time[-1] < self._drawn[0])
        if not new.any():
            return
        for name in (*batch.parts, DAMPING):
            self._rec.line(_path(name), effect(name))
        for path, values in columns(batch).items():
            self._rec.series(path, time[new], values[new])
        self._drawn = batch.time[0], batch.time[-1]

    def _draw_found(self) -> None:
        """The parameters of what is found and not in force, each with its interval, at the clocks that are set."""
        for each in self._ledger.found:
            name, intervals = str(each.get("effect", "?")), each.get("interval") or {}
            for key, value in (each.get("parameters") or {}).items():
                if not isinstance(value, float | int):
                    continue
                path = f"effects/found/{_entity(name)}/{key}"
                self._found[path] = name, key
                low, high = intervals.get(key) or (value, value)
                for line, number, title, colour in (
                    ("estimate", value, "Estimate", LIGHT.new),
                    ("low", low, "95 %, lower end", LIGHT.discarded),
                    ("high", high, "95 %, upper end", LIGHT.discarded),
                ):
                    self._rec.line(f"{path}/{line}", title, colour)
                    self._rec.log(f"{path}/{line}", rr.Scalars(float(number)))

    def _tell(self) -> None:
        self._rec.write("effects/ledger", ledger_text(self._ledger, self._rec.words))


def columns(batch: Batch) -> dict[str, Floats]:
    """Entity → (n,) moments [N m]: the torque, measured and predicted, and each part, the damping as predicted.

    The parts add up to the prediction.
    """
    parts = {name: np.array(values) for name, values in batch.parts.items()}
    rest = np.sum(list(parts.values()), axis=0)
    found = {"effects/torque/measured": rest + np.array(batch.damping)}
    if batch.predicted is not None:
        parts[DAMPING] = np.array(batch.predicted)
        found["effects/torque/predicted"] = rest + parts[DAMPING]
    return found | {_path(name): part for name, part in parts.items()}


def _path(name: str) -> str:
    """Where a part of the torque is logged; a channel's effect is called coupling:sway, which no entity may be."""
    return f"effects/parts/{_entity(name)}"


def _entity(name: str) -> str:
    return name.replace(" ", "_").replace(":", "_")


def ledger_text(ledger: EffectsLedger, axis: AxisWords = YAW_WORDS) -> str:
    """Markdown: the effects in force, then every step that led there."""
    lines = ["# Traced effects", ""]
    if ledger.found and not ledger.effects:
        lines.append(
            "None is in force. The plots show the parameters of what was found, each with its interval of 95 %; "
            "`incsvr effects promote NAME` puts it in force."
        )
    elif not ledger.effects:
        lines.append(
            f"None: the model is the declared {axis.inertia} and the learned damping.\n\n`incsvr trace RECORDING… "
            "--json FILE` finds effects that it lacks. With `effects: FILE` in its configuration the learner applies "
            "them; with `tracing.live: advise` or `adopt` it finds them by itself. The plots show the parts of "
            f"every {axis.effort}."
        )
    for found in ledger.effects:
        lines += _about(found, axis)
    if ledger.found:
        lines.append("\n# Found, not in force")
    for found in ledger.found:
        lines += _about(found, axis)
    if ledger.history:
        lines += ["\n## Ledger", *(f"- {step(entry)}" for entry in ledger.history[-30:])]
    return "\n".join(lines)


def _about(found: dict[str, Any], axis: AxisWords) -> list[str]:
    """An effect: what it is, how sure, and its errors before and after where they are known."""
    state = found.get("state")
    lines = [f"## {effect(str(found.get('effect', '?')))}" + (f" ({state})" if state else "")]
    if found.get("sentence"):
        lines.append(str(found["sentence"]))
    intervals = found.get("interval") or {}
    values = (found.get("parameters") or {}).items()
    lines += [f"- {words(parameter(name, value, intervals.get(name), axis))}" for name, value in values]
    if found.get("share") is not None:
        p = chance(found.get("p_value", 0), 1)
        lines.append(f"- {100 * found['share']:.0f} % of the better fit, p {p}")
    if found.get("error"):
        lines.append(f"- On fresh data, without → with it: {errors(found['error'], axis)}")
    return lines
