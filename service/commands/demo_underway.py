"""The demo's third act: what the learner finds, on its own, of an effect that comes on while the vehicle moves.

The learner advises (`tracing.live: advise`): what it serves stays what it would be without. What came on is drawn by a
seed in the simulator's process, which tells it once all has been played.
"""

from __future__ import annotations

import queue
import textwrap
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, TextIO

import numpy as np

from incsvr.compensation.proof import errors
from incsvr.effects.torque_asymmetry import THRUST_TABLE_ERROR
from service.cli.output import WIDTH
from service.wire import EffectsLedger

WINDOW_S = 400.0
"""The learner traces over so much [s]: the act lasts 800 s, and the vehicle turns back and forth every few seconds."""
PROOF_S = 60.0
"""Effects prove themselves on so much fresh data [s]."""
SETTINGS = ("tracing.live=advise", f"tracing.window={WINDOW_S:g}", f"tracing.proof={PROOF_S:g}")
OPENING_WORDS = """\
Third act: the vehicle continues with its hull. At a hidden instant the
simulator switches on an effect, which its seed selects. The learner's findings:"""
LEDGER_TIMEOUT_S = 40.0
"""The time for which traces and proofs are awaited after the last measurement [s], wall time; they take ten."""
IDLE_S = 0.5
"""The idle time that counts as the end of tracing [s]: the next piece of work begins within a tenth of it."""


class Steps:
    """Prints the ledger's steps of the act that begins at a time [s], each once, as they come."""

    def __init__(self, begins: float, people: TextIO) -> None:
        self._begins, self._people, self._told = begins, people, 0
        self._begun = False

    def begin(self) -> None:
        if not self._begun:
            print(f"\n{OPENING_WORDS}", file=self._people, flush=True)
            self._begun = True

    def tell(self, ledger: EffectsLedger) -> None:
        steps = [step for step in ledger.history if step["t"] > self._begins]
        for step in steps[self._told :]:
            self.begin()
            print(step_line(step), file=self._people, flush=True)
        self._told = max(self._told, len(steps))


def step_line(step: Mapping[str, Any]) -> str:
    """A step of the ledger, in at most 80 columns."""
    about = "" if step["effect"] == "residual" else f"{step['effect']}: "
    why = str(step["why"]).removeprefix(about)
    head = f"{step['t']:6.0f} s  {step['step']}: "
    return textwrap.fill(f"{about}{why}", WIDTH, initial_indent=head, subsequent_indent=" " * 10)


def awaited(
    ask: Callable[[], EffectsLedger],
    ledgers: queue.Queue[EffectsLedger],
    alive: Callable[[], bool],
    tell: Callable[[EffectsLedger], None],
) -> EffectsLedger:
    """The ledger once nothing is at work beside the learner, or LEDGER_TIMEOUT_S are over; each is told as it comes."""
    until, still = time.monotonic() + LEDGER_TIMEOUT_S, time.monotonic()
    while time.monotonic() < until and alive():
        with suppress(queue.Empty):
            tell(ledgers.get(timeout=0.1))
        ledger = ask()
        if ledger.work is not None:
            still = time.monotonic()
        elif time.monotonic() > still + IDLE_S:
            break
    ledger = ask()
    tell(ledger)
    return ledger


def outcome(ledger: EffectsLedger, begins: float, seed: int, truth: Mapping[str, Any]) -> dict[str, Any]:
    """The findings of the act that begins at a time [s], and the ground truth.

    `right` says whether what was proven, or else what was suspected, is what came on or is in a class with it;
    `sizes` compares what acts: the thrust at the largest command, or the parameter where no thrust changes.
    """
    proven = [finding for finding in ledger.found if finding["state"] == "proven"]
    judged = proven or list(ledger.found)
    named = {str(finding["effect"]) for finding in judged}
    classes = {str(name) for finding in judged for name in finding.get("cannot_tell_from", ())}
    return {
        "seed": seed,
        "begins": begins,
        "found": list(ledger.found),
        "history": list(ledger.history),
        "served_effects": list(ledger.effects),
        "truth": dict(truth),
        "proven": bool(proven),
        "right": truth["effect"] in named | classes,
        "sizes": [
            size for finding in judged if finding["effect"] == truth["effect"] for size in _sizes(finding, truth)
        ],
    }


def _sizes(finding: Mapping[str, Any], truth: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Each size that was found, its 95 % interval and the true one; it holds within that or a thrust table's error."""
    if truth["thrust_nm"]:
        commands, made = zip(*truth["thrust_nm"], strict=True)
        sizes = [
            (
                f"thrust at {command:g} N m commanded",
                found,
                low,
                high,
                float(np.interp(command, commands, made)),
                command,
            )
            for command, found, low, high in finding.get("thrust_nm", ())
        ]
    else:
        sizes = [
            (name, found, *finding["interval"][name], truth["parameters"][name], truth["parameters"][name])
            for name, found in finding["parameters"].items()
            if name in truth["parameters"]
        ]
    return [
        {"what": what, "found": found, "low": low, "high": high, "true": true,
         "holds": low <= true <= high or abs(found - true) <= THRUST_TABLE_ERROR * abs(whole)}
        for what, found, low, high, true, whole in sizes
    ]  # fmt: skip


def summary(act: Mapping[str, Any]) -> list[str]:
    """The findings with the errors before and after, followed by the ground truth."""
    lines = []
    for finding in act["found"]:
        lines += textwrap.wrap(f"{finding['state']}: {finding['sentence']}", WIDTH)
        error = finding.get("error")
        if error:
            until = f"on data after its trace, until {finding['until']:.0f} s:"
            lines += textwrap.wrap(f"{until} {errors(error)}", WIDTH, initial_indent="  ", subsequent_indent="  ")
    if not act["found"]:
        lines.append("The learner has found no known effect.")
    truth = act["truth"]
    lines += textwrap.wrap(f"Ground truth: {truth['effect']} since {truth['since']:.0f} s.", WIDTH)
    for size in act["sizes"]:
        found = f"found {size['found']:.3g} ({size['low']:.3g} to {size['high']:.3g})"
        lines += textwrap.wrap(f"{size['what']}: {found}, true {size['true']:.3g}", WIDTH, subsequent_indent="  ")
    lines += textwrap.wrap(_judgement(act), WIDTH)
    return lines


def _judgement(act: Mapping[str, Any]) -> str:
    if not act["found"]:
        return "It was not found: within this act the data did not distinguish it from noise."
    if not act["right"]:
        return "A different effect was found: an operator who promoted it would have been misled."
    if not act["sizes"]:
        return f"In part: these data cannot distinguish what was found from {act['truth']['effect']}."
    if not all(size["holds"] for size in act["sizes"]):
        return "In part: the effect is the true one, its size is not."
    when = next(
        step["t"] for step in act["history"] if step["t"] > act["begins"] and step["step"] in ("suspected", "proven")
    )
    after = when - act["truth"]["since"]
    proven = "proven since" if act["proven"] else "not proven on fresh data until the end"
    return f"Correct: first suspected {after:.0f} s after it began, and {proven}."
