"""`incsvr effects`: what a running learner has found beside its model, and an operator's word on it."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

from incsvr.compensation.proof import errors
from incsvr.errors import BadInput
from incsvr.numerics.plain import to_plain
from incsvr.plant.axes import AXES
from incsvr.plant.words import YAW_WORDS, AxisWords, words_of
from service.bus.client import NoAnswer, bus_client
from service.cli.output import emit
from service.commands.arguments import add_question_arguments
from service.config.configuration import Config
from service.config.sources import from_arguments
from service.wire import EffectsLedger

VERBS = ("promote", "withdraw")
SHOWN_STEPS = 20
"""Steps for people; all that are kept go into the JSON object."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("verb", nargs="?", choices=VERBS, help="decide as the bus's operator; without it: list all")
    parser.add_argument("name", nargs="?", metavar="NAME", help="effect to decide on, such as torque_lag")
    add_question_arguments(parser)


def run(args: argparse.Namespace) -> int:
    config = from_arguments(args)
    if args.verb is not None and args.name is None:
        raise BadInput(
            f"name the effect to {args.verb}, such as torque_lag; `incsvr effects` lists those that are there"
        )
    try:
        ledger = ask(config, args.verb, args.name, args.wait)
    except NoAnswer as error:
        if args.verb is None:
            raise
        raise NoAnswer(f"{error}; on a secured bus only the role operator may decide") from error
    told = to_plain(ledger)
    del told["batch"]
    emit(args, told, text(ledger, words_of(AXES[config.vehicle.axis])))
    return 0


def ask(config: Config, verb: str | None, name: str | None, patience_s: float) -> EffectsLedger:
    """The ledger, after what was decided; a question whose answer is lost is asked again, and changes nothing then.

    Raises:
        NoAnswer: nobody answers within the time.
        BadInput: the learner refuses.
    """
    with bus_client(config, patience_s) as client:
        decided = {"promote": client.keys.promote, "withdraw": client.keys.withdraw}
        selector = client.keys.effects if verb is None else f"{decided[verb]}?effect={name}"
        return client.ask(selector, EffectsLedger)


def text(ledger: EffectsLedger, words: AxisWords = YAW_WORDS) -> str:
    """The ledger for people."""
    lines = [f"live tracing: {ledger.mode}", f"in force: {_names(ledger.effects)}"]
    lines += [f"  {effect['sentence']}" for effect in ledger.effects if effect.get("sentence")]
    lines.append(f"found, not in force: {_names(ledger.found)}")
    for finding in ledger.found:
        lines += _found(finding, words)
    if ledger.history:
        lines.append("  t [s]  revision  step              effect: why")
        lines += [_step(step) for step in ledger.history[-SHOWN_STEPS:]]
    return "\n".join(lines)


def _names(findings: tuple[dict[str, Any], ...]) -> str:
    return ", ".join(str(finding.get("effect")) for finding in findings) or "nothing"


def _found(finding: Mapping[str, Any], words: AxisWords) -> list[str]:
    lines = [f"  {finding.get('effect')}, {finding.get('state')}: {finding.get('sentence', '')}"]
    if finding.get("error"):
        changed = errors(finding["error"], words)
        lines.append(f"    on fresh data until {finding['until']:.0f} s, before → after: {changed}")
    lines.append(f"    incsvr effects promote {finding.get('effect')}")
    return lines


def _step(step: Mapping[str, Any]) -> str:
    t, revision = step.get("t"), step.get("revision")
    when = "–" if t is None else f"{t:.0f}"
    served = "–" if revision is None else str(revision)
    return f"{when:>7s}  {served:>8s}  {step.get('step', ''):16s}  {step.get('effect')}: {step.get('why', '')}"
