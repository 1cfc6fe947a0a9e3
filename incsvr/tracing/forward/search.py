"""Which effects the model lacks: the best one is added, what no longer pays goes, neighbours are tried in its place.

Every candidate is judged by 2 Δℓ of the forward form less the price of its parameters (question.py); in open loop the
free run may veto it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from incsvr.effects import Signals
from incsvr.tracing.forward.candidates import starts
from incsvr.tracing.forward.equations import Part, columns, predicted
from incsvr.tracing.forward.fit import Fit, fit
from incsvr.tracing.forward.grid import Grid
from incsvr.tracing.forward.projection import Lead, Projection
from incsvr.tracing.forward.question import Question
from incsvr.tracing.forward.thresholds import MISFIT, RELEVANT, REQUIRED_GAIN

Array = NDArray[np.float64]

LEADS = 6
"""Candidates that are fitted in full in each round: the scan, with the noise as it was, puts the truth among them."""

MOST = 6
"""Effects that are looked for."""


ROUNDS = 5
"""In which a searched parameter and the noise follow each other at most."""

QUICK = 5
"""Steps of the noise's search beside a parameter that moved by little."""

FORMS = 2
"""Of them, of one effect at most."""

CLIMBED = 2
"""Of them, the best, whose parameter is found with the noise anew at every step."""

STEP, SMALLEST = 1.4, 1.02
"""Factors by which a thrust effect's parameter climbs at first and at last."""

CLOSE = 0.01
"""Relative change of a searched parameter below which it stands."""


@dataclass(frozen=True, slots=True)
class Found:
    """What a search found.

    Attributes:
        base: without effects.
        best: with them.
        gains: for each, 2 Δℓ of the whole over the whole without it, less its price.
        refused: name → why the nearest candidates are not among them.
        leads: the last scan, the most telling first.
    """

    base: Fit
    best: Fit
    gains: tuple[float, ...]
    refused: dict[str, str]
    leads: tuple[Lead, ...]


def search(question: Question, base: Fit) -> Found:
    """The effects that pay, beginning with none."""
    best, refused = base, dict[str, str]()
    leads = scan(question, best)
    for _ in range(2 * MOST):
        grown = _grown(question, best, leads, refused)
        if grown is None or len(grown.parts) > MOST:
            break
        kept = _pruned(question, _swapped(question, grown))
        if set(kept.names()) == set(best.names()):
            best = max(best, kept, key=lambda fitted: fitted.log_likelihood)
            break
        best = kept
        leads = scan(question, best)
    base = base if best.parts or base.log_likelihood >= best.log_likelihood else best
    gains = tuple(gain_of(question, best, k) for k in range(len(best.parts)))
    return Found(base, best, gains, refused, tuple(leads))


def required(fitted: Fit) -> float:
    """2 Δℓ above its price that an effect must bring: more, where the commands tell what the log does not hold.

    A controller that sees another gyro than the log's answers what that gyro saw. Next to what its commands still tell
    of the innovations, an effect that explains as much is of the same kind.
    """
    return REQUIRED_GAIN + MISFIT * fitted.misfit


def without(grid: Grid, fitted: Fit, k: int) -> Fit:
    """The fit without its k-th effect."""
    return fit(grid, [part for j, part in enumerate(fitted.parts) if j != k], fitted)


def gain_of(question: Question, fitted: Fit, k: int) -> float:
    """2 Δℓ of the k-th effect less its price."""
    reduced = without(question.grid, fitted, k)
    return 2.0 * (fitted.log_likelihood - reduced.log_likelihood) - question.price(fitted.parts[k])


def scan(question: Question, fitted: Fit) -> list[Lead]:
    """The best start of each effect that is not in the fit, by 2 Δℓ less its price, with the noise as it stands.

    All innovations count alike: what an effect does for moments only, the fit without it takes for outliers. And what
    lasts, the fit without it takes for water that lasts: so each start is looked at beside water of the motion's own
    time scale, too.
    """
    everywhere = replace(fitted, weight=np.ones_like(fitted.weight), sigma=float(np.std(fitted.innovation)))
    views = [Projection(question.grid, everywhere)]
    shorter = fitted.noise.within(question.grid.cell, question.grid.signals.scale)
    if shorter != fitted.noise:
        views.append(
            Projection(question.grid, fit(question.grid, fitted.parts, replace(fitted, noise=shorter), search=0))
        )
    leads = list[Lead]()
    for effect in question.effects:
        if effect.name in fitted.names():
            continue
        begun = [view.try_start(part) for view in views for part in starts(effect, view.signals)]
        if begun:
            best = max(begun, key=lambda lead: lead.gain)
            leads.append(Lead(best.part, best.gain - question.price(best.part)))
    return sorted(leads, key=lambda lead: -lead.gain)


def settled(grid: Grid, fitted: Fit, part: Part) -> Fit:
    """The fit with one more part, its searched parameter and the noise found anew."""
    for _ in range(ROUNDS):
        projection = Projection(grid, fitted, part)
        begun = [projection.try_start(start) for start in starts(part.effect, projection.signals)]
        refined = projection.refined(max([Lead(part, projection.gain(part)), *begun], key=lambda lead: lead.gain).part)
        fitted = fit(grid, [*(p for p in fitted.parts if p.name != part.name), refined], fitted)
        if not part.searched or abs(refined.parameter - part.parameter) <= CLOSE * abs(refined.parameter):
            break
        part = fitted.parts[-1]
    return fitted


def climbed(grid: Grid, fitted: Fit) -> Fit:
    """The fit with the last part's parameter where the likelihood is greatest, the noise found anew at every step.

    A scan keeps the noise. But what a dead band or a slow rotor leaves in a closed loop looks like water of another
    colour, beside which a wrong size seems right.
    """
    if not fitted.parts[-1].thrust:
        return fitted
    step, way = STEP, 1.0
    while step > SMALLEST:
        *others, part = fitted.parts
        for side in (way, -way):  # on the way that led up, the other side need not be tried again
            there = part.moved(part.parameter * step**side)
            tried = fit(grid, [*others, there], fitted, search=QUICK, passes=1)
            if tried.log_likelihood > fitted.log_likelihood:
                fitted, way = tried, side
                break
        else:
            step = step**0.4
    return fit(grid, fitted.parts, fitted)


def objection(grid: Grid, fitted: Fit, k: int) -> str:
    """Why physics or relevance forbid the k-th effect; empty if they do not."""
    part, s = fitted.parts[k], predicted(grid, fitted.model).signals
    reason = part.effect.implausible(part.term, s) or part.effect.slight(part.term, s)
    if reason:
        return reason
    if part.thrust and part.effect.lingers and abs(part.parameter) < grid.resolution:
        return "it is less than a sample of the streams"
    if not is_relevant(s, part):
        return f"it moves less than {RELEVANT:.0%} of the torque, less than a thrust table is known"
    return ""


def is_relevant(signals: Signals, part: Part) -> bool:
    """Whether it moves as much of the torque as matters; of a vehicle whose thrusters stand still, anything does."""
    return bool(np.mean(loss_of(signals, part) ** 2) >= RELEVANT**2 * np.mean(signals.torque**2))


def loss_of(signals: Signals, part: Part) -> Array:
    """(n,) what the part takes of the torque [N m]."""
    if part.thrust:
        return np.asarray(signals.torque - part.effect.thrust(signals.torque, signals, part.term))
    return np.asarray(np.array(part.term.coefficients) @ columns(part, signals))


def _grown(question: Question, best: Fit, leads: Sequence[Lead], refused: dict[str, str]) -> Fit | None:
    """The fit with the one more effect that pays most; None where none pays."""
    chosen = list[Lead]()
    for lead in leads:
        forms = sum(other.part.name == lead.part.name for other in chosen)
        if lead.gain > 0.0 and forms < FORMS and len(chosen) < LEADS:
            chosen.append(lead)
    tried = [settled(question.grid, best, lead.part) for lead in chosen]
    tried.sort(key=lambda fitted: question.price(fitted.parts[-1]) - 2.0 * fitted.log_likelihood)
    tried[:CLIMBED] = [climbed(question.grid, fitted) for fitted in tried[:CLIMBED]]
    grown, most = None, 0.0
    for fitted in tried:
        gain = 2.0 * (fitted.log_likelihood - best.log_likelihood) - question.price(fitted.parts[-1])
        reason, required_gain = objection(question.grid, fitted, len(fitted.parts) - 1), required(fitted)
        if reason or gain < required_gain:
            name = fitted.parts[-1].name
            refused[name] = reason or f"it brings {gain:.3g} of the {required_gain:.3g} that are asked"
        elif gain > most:
            grown, most = fitted, gain
    if grown is not None:
        refused.pop(grown.parts[-1].name, None)
    return grown


def _pruned(question: Question, best: Fit) -> Fit:
    """The fit without what no longer pays beside the others."""
    while best.parts:
        without_each = [without(question.grid, best, k) for k in range(len(best.parts))]
        gains = [
            2.0 * (best.log_likelihood - reduced.log_likelihood) - question.price(part)
            for part, reduced in zip(best.parts, without_each, strict=True)
        ]
        worst = int(np.argmin(gains))
        if gains[worst] >= required(best) and not objection(question.grid, best, worst):
            return best
        best = without_each[worst]
    return best


def _swapped(question: Question, best: Fit) -> Fit:
    """The fit with one effect in another's place, as long as that explains more for its price."""
    for k in range(len(best.parts)):
        reduced, part = without(question.grid, best, k), best.parts[k]
        others = [lead for lead in scan(question, reduced) if lead.part.effect.key != part.effect.key]
        for lead in others[:2]:
            tried = climbed(question.grid, settled(question.grid, reduced, lead.part))
            more = 2.0 * (tried.log_likelihood - best.log_likelihood) + question.price(part) - question.price(lead.part)
            if more > 0.0 and not objection(question.grid, tried, len(tried.parts) - 1):
                best = tried
                break
    return best
