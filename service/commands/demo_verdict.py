"""The demo's third act: what the learner found of the effect that the simulator switched on, judged by the truth."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import Any

import numpy as np

from incsvr.compensation.proof import errors
from service.cli.output import WIDTH
from service.wire import EffectsLedger

THRUST_TABLE_ERROR = 0.05
"""Part of the thrust within which no thrust table is known."""


def outcome(ledger: EffectsLedger, begins: float, seed: int, truth: Mapping[str, Any]) -> dict[str, Any]:
    """What the learner found in the act that begins at a time [s]; `right` judges the effect, `sizes` the thrust at the
    largest command, or the parameters where no thrust changes: of what is proven, or else of what is suspected."""
    proven = [finding for finding in ledger.found if finding["state"] == "proven"]
    judged = proven or list(ledger.found)
    alike = {str(name) for finding in judged for name in (finding["effect"], *finding.get("cannot_tell_from", ()))}
    return {
        "seed": seed,
        "begins": begins,
        "found": list(ledger.found),
        "history": list(ledger.history),
        "served_effects": list(ledger.effects),
        "truth": dict(truth),
        "proven": bool(proven),
        "right": truth["effect"] in alike,
        "sizes": [size for one in judged if one["effect"] == truth["effect"] for size in _sizes(one, truth)],
    }


def _sizes(finding: Mapping[str, Any], truth: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Each size that was found, its 95 % interval and the true one; it holds within that or a thrust table's error."""
    if truth["thrust_nm"]:
        commands, made = zip(*truth["thrust_nm"], strict=True)
        rows = list(finding.get("thrust_nm", ()))
        sizes = [
            (f"thrust at {command:g} N m commanded", *found, float(np.interp(command, commands, made)), command)
            for command, *found in (rows[:1] + rows[1:][-1:])
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


def verdict(act: Mapping[str, Any]) -> list[str]:
    """The steps and findings with the errors before and after, the ground truth, and whether they agree."""
    steps = [f"{e['effect']} {e['step']} at {e['t']:.0f} s" for e in act["history"] if e["t"] > act["begins"]]
    said = [f"In the third act: {', '.join(steps) or 'no finding'}."]
    for finding in act["found"]:
        said.append(f"{finding['state']}: {finding['sentence']}")
        if finding.get("error"):
            said.append(f"  on data after its trace, until {finding['until']:.0f} s: {errors(finding['error'])}")
    said.append(f"Ground truth: {act['truth']['effect']} since {act['truth']['since']:.0f} s.")
    form = "{what}: found {found:.3g} ({low:.3g} to {high:.3g}), true {true:.3g}"
    said += [*(form.format(**size) for size in act["sizes"]), _judgement(act)]
    return [line for each in said for line in textwrap.wrap(each, WIDTH, subsequent_indent="  ")]


def _judgement(act: Mapping[str, Any]) -> str:
    if not act["found"]:
        return "The learner found no known effect: the data of this act did not distinguish it from noise."
    if not act["right"]:
        return "A different effect was found: an operator who promoted it would have been misled."
    if not act["sizes"]:
        return f"In part: these data cannot distinguish what was found from {act['truth']['effect']}."
    if not all(size["holds"] for size in act["sizes"]):
        return "In part: the effect is the true one, its size is not."
    since, begins = act["truth"]["since"], act["begins"]
    steps = [(each["step"], each["t"] - since) for each in act["history"] if each["t"] > begins]
    first = next(after for step, after in steps if step in ("suspected", "proven"))
    proved = [f"proven after {after:.0f} s" for step, after in steps if step == "proven" and act["proven"]]
    proven = proved[0] if proved else "not proven on fresh data"
    return f"Correct: first suspected {first:.0f} s after it began, {proven}."
