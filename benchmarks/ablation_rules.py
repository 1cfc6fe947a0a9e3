"""The rules of the tracer, and what takes each of them out: what it does where it finds nothing, in its place."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np

from incsvr.effects import Effect
from incsvr.tracing.forward.thresholds import REQUIRED_GAIN
from incsvr.tracing.weak.evidence import gain_of
from incsvr.tracing.weak.free_run_comparison import gained
from incsvr.tracing.weak.hypothesis import Hypothesis
from incsvr.tracing.weak.indistinguishable import indistinguishable
from incsvr.tracing.weak.pipeline import Case, Indistinguishable
from incsvr.tracing.weak.validation import _gain


@dataclass(frozen=True, slots=True)
class Patch:
    """One name of one module, and what stands there instead.

    Attributes:
        module: its name.
        name: in it, of a method with its class.
        instead: a function, a property or a number.
        watched: whether each call may be compared with the replacement's: where none of a recording differs, the rule
            did nothing there, and the answer without it is the same. Else it is taken to act everywhere.
    """

    module: str
    name: str
    instead: Any
    watched: bool = True

    def apply(self) -> None:
        """Put the replacement in place, for good."""
        owner, last = self._place()
        setattr(owner, last, self.instead)

    @contextmanager
    def observed(self, acted: Callable[[], None]) -> Iterator[None]:
        """Calls `acted` whenever the rule does something else than its replacement would."""
        if not self.watched:
            acted()
            yield
            return
        owner, last = self._place()
        there = getattr(owner, last)
        ours, theirs = (_called(each) for each in (there, self.instead))

        def both(*args: Any, **named: Any) -> Any:
            found = ours(*args, **named)
            if not _same(found, theirs(*args, **named)):
                acted()
            return found

        setattr(owner, last, property(both) if isinstance(there, property) else both)
        try:
            yield
        finally:
            setattr(owner, last, there)

    def _place(self) -> tuple[Any, str]:
        *path, last = self.name.split(".")
        return reduce(getattr, path, importlib.import_module(self.module)), last


def _called(there: Any) -> Any:
    """The function itself, of a property the one that reads it."""
    return there.fget if isinstance(there, property) else there


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other)
    try:
        return bool(one is other or one == other)
    except ValueError:  # two hypotheses whose arrays differ
        return False


def _all_of_them(case: Case, found: Hypothesis, _: dict[str, str]) -> tuple[Hypothesis, Indistinguishable]:
    every = range(len(found.terms))
    return found, tuple(indistinguishable(case.problem, found, k, case.effects) for k in every)


def _subclasses(parent: type, method: str) -> list[type]:
    children: list[type] = parent.__subclasses__()
    below = [each for child in children for each in _subclasses(child, method)]
    return [parent, *below] if method in vars(parent) else below


def _of_effects(method: str, instead: Any) -> list[Patch]:
    """Patches of a method of every effect that has one of its own."""
    return [
        Patch(each.__module__, f"{each.__name__}.{method}", instead)
        for each in dict.fromkeys(_subclasses(Effect, method))
    ]


WEAK, FORWARD = "incsvr.tracing.weak.", "incsvr.tracing.forward."

RULES: Mapping[str, Sequence[Patch]] = {
    "forward form leads where a controller answers a command": [
        Patch(FORWARD + "loop", "Loop.closed", property(lambda _: False))
    ],
    "forward form judges the others of a command": [Patch("incsvr.tracing.trace", "_unsupported", lambda *_: {})],
    "forward: a searched parameter climbs with the noise anew": [
        Patch(FORWARD + "search", "climbed", lambda _, fitted: fitted)
    ],
    "forward: swapping": [Patch(FORWARD + "search", "_swapped", lambda _, best: best)],
    "forward: more asked beside what commands still tell": [
        Patch(FORWARD + "search", "required", lambda _: REQUIRED_GAIN)
    ],
    "forward: spikes taken out": [Patch(FORWARD + "interpolation", "without_spikes", lambda values: values)],
    "forward: relevance": [Patch(FORWARD + "search", "is_relevant", lambda *_: True)],
    "inertia wrong by a factor, told by the free run": [
        Patch("incsvr.tracing.output_error", "Identified.contradicts", lambda *_: False)
    ],
    "weak: noise in the torque": [
        Patch(WEAK + "problem", "Problem.noise_fraction_beside", lambda *_: 0.0, watched=False),
        Patch(WEAK + "alignment", "_late_noise_fraction", lambda *_: 0.0, watched=False),
        Patch(WEAK + "problem", "Problem.knows_command", lambda *_: False, watched=False),
    ],
    "weak: noise of the instants of jumps": [Patch(WEAK + "whitening", "FEWEST_JUMPS", 10**9, watched=False)],
    "weak: a controller's answer": [Patch(WEAK + "problem", "Problem.feedback_beside", lambda *_, **__: 0.0)],
    "weak: a command of levels behind the noise": [Patch(WEAK + "problem", "Problem.knows_command", lambda *_: False)],
    "weak: levels that a command comes back to": [Patch(WEAK + "command", "shared", lambda _: None)],
    "weak: Jacobian of what answers the noise": [
        Patch(WEAK + "whitening", "answering", lambda *_: [], watched=False),
        Patch(WEAK + "refining", "answering", lambda *_: [], watched=False),
    ],
    "weak: noise at the effect's own frequencies": [
        Patch(WEAK + "acceptance", "evidence", gain_of, watched=False),
        Patch(WEAK + "pipeline", "evidence", gain_of, watched=False),
    ],
    "weak: an offset within the sampling pays": [Patch(WEAK + "hypothesis", "ALIGNMENT", 0.0, watched=False)],
    "weak: tied with an offset within the sampling": [
        Patch(WEAK + "pipeline", "_beyond_sampling", _all_of_them, watched=False)
    ],
    "weak: a filter on the torque's noise is no evidence": [
        Patch(WEAK + "hypothesis", "noise_gain", lambda *_: 0.0),
        Patch(WEAK + "indistinguishable", "noise_gain", lambda *_: 0.0),
    ],
    "weak: second scan as if the noise were white": [Patch(WEAK + "scan", "SWALLOWED", 0, watched=False)],
    "weak: rules for one sine": [Patch(WEAK + "problem", "Problem.one_sine", property(lambda _: False))],
    "weak: free run as a judge": [
        Patch(WEAK + "acceptance", "pays", lambda *_: True),
        Patch(WEAK + "search", "pays", lambda *_: True),
    ],
    "weak: free runs compared by the likelihood of their errors": [
        Patch(WEAK + "validation", "Validation._gains", lambda _, before, after: gained(_gain(before, after)))
    ],
    "weak: free runs put on time": [Patch(WEAK + "validation", "Validation.late", lambda *_: 0.0)],
    "weak: climbing": [Patch(WEAK + "search", "Search.climbed", lambda _, base: base)],
    "weak: short memories must prove themselves": _of_effects("must_prove", lambda *_: False),
    "too slight to matter": _of_effects("slight", lambda *_: ""),
}
"""Of each rule, what takes it out."""
