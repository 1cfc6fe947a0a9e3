"""The effects of `incsvr trace` in the learner: those in force, and the reasons against the others."""

from __future__ import annotations

import json
import zlib
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from incsvr.errors import BadInput
from service.config.configuration import Config
from service.wire.json_text import read_json

if TYPE_CHECKING:
    from incsvr.compensation.effects_in_force import Compensation
    from incsvr.plant.body import Coupled

OperatorVerb = Literal["promote", "withdraw"]
"""The decisions of an operator about an effect."""
BY_LEARNING = "the learned damping follows the vehicle by itself"
OF_CLOCK = "it refers to the clock of the traced recording"
"""Why an effect is left out."""
_AGAIN = "write one with `incsvr trace RECORDING… --json FILE`"


@dataclass(frozen=True, slots=True)
class TracedEffects:
    """The effects of a trace, as far as they hold on another recording.

    Attributes:
        compensation: works them out along the streams.
        findings: those in force, in the form of CONTRACT, Section 5.
        history: what was done with each term of the traced model.
        warnings: sentences about what is missing.
    """

    compensation: Compensation
    findings: tuple[dict[str, Any], ...]
    history: tuple[dict[str, Any], ...]
    warnings: tuple[str, ...]

    @property
    def identity(self) -> str:
        """Tells apart the effects that a state was learned with: names, and a check of their values."""
        values = json.dumps(self.compensation.model.to_dict()["effects"])
        return f"{', '.join(self.compensation.names) or 'nothing'} ({zlib.crc32(values.encode()):08x})"

    @property
    def names(self) -> tuple[str, ...]:
        """The effects in force that are named by findings; all where nothing says which."""
        found = {finding["effect"] for finding in self.findings}
        return tuple(name for name in self.compensation.names if name in found) or self.compensation.names


def configured_effects(config: Config) -> TracedEffects | None:
    """The effects that a learner is configured with; BadInput where they are not usable."""
    if config.effects is None:
        return None
    return read_effects(config.effects, config.vehicle.inertia, config.signals.channels, config.coupled())


def read_effects(
    path: Path, inertia: float, channels: tuple[str, ...], coupled: Coupled | None = None
) -> TracedEffects:
    """The effects in a file that `incsvr trace --json FILE` wrote.

    Args:
        path: the file.
        inertia: I, as it is configured [kg m²].
        channels: the further channels that every sample needs.
        coupled: the axis in its body, as it is configured; None where it is taken by itself.

    Raises:
        BadInput: naming the file and the cure.
    """
    found = _trace(path)
    of_body = (found.get("coupled") or {}).get("mass_matrix")
    if of_body != (None if coupled is None else coupled.mass.ravel().tolist()):
        how = "without a mass matrix" if of_body is None else "with a mass matrix"
        here = "none is" if coupled is None else "one is" if of_body is None else "another one is"
        raise BadInput(
            f"{path}: traced {how}, and {here} configured; trace again with the same vehicle.mass_matrix "
            "(`incsvr trace --config FILE`)"
        )
    return effects_from_trace(found["model"], found["effects"], inertia, channels, str(path))


def effects_from_trace(
    model: Mapping[str, Any],
    traced: Iterable[Mapping[str, Any]],
    inertia: float,
    channels: tuple[str, ...],
    source: str,
    again: str = _AGAIN,
) -> TracedEffects:
    """The effects of a trace that was read from `source`, by its model and its findings; otherwise as `read_effects`.

    Args:
        traced: the findings, in the form that `incsvr trace --json` writes.
        again: what helps where they are of another version.
    """
    # Loaded where it is needed alone: most learners have no traced effects.
    from incsvr.compensation.effects_in_force import FOLLOWED_BY_LEARNING, Compensation
    from incsvr.tracing.model import TracedModel

    try:
        traced_model = TracedModel.from_dict(model)
        compensation = Compensation.of(traced_model)
        findings = tuple(dict(finding) for finding in traced if finding["effect"] in compensation.names)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, StopIteration) as error:
        raise BadInput(
            f"{source}: this is no trace of this version ({type(error).__name__}: {error}); {again}"
        ) from None
    declared = traced_model.inertia
    if declared != inertia:
        raise BadInput(
            f"{source}: traced with a declared inertia of {declared:g} kg m², and the configured one is "
            f"{inertia:g} kg m²; trace again with --inertia {inertia:g}, or set vehicle.inertia to {declared:g}"
        )
    for name in compensation.channels:
        if name not in channels:
            raise BadInput(
                f"{source}: an effect reads the channel {name}, which signals.channels does not list; record or "
                f"publish it, and add {name} to signals.channels"
            )
    named = {finding["effect"] for finding in findings}
    why = {name: BY_LEARNING if name in FOLLOWED_BY_LEARNING else OF_CLOCK for name in compensation.left_out}
    return TracedEffects(
        compensation,
        findings,
        (
            *({"effect": name, "step": "in force", "why": _why(name, named)} for name in compensation.names),
            *({"effect": name, "step": "left out", "why": because} for name, because in why.items()),
        ),
        tuple(
            f"the traced effect {name} is left out: {because}" for name, because in why.items() if because == OF_CLOCK
        ),
    )


def _why(name: str, named: Collection[str]) -> str:
    return "traced" if name in named else "fitted beside the effects found"


def _trace(path: Path) -> Mapping[str, Any]:
    try:
        found = read_json(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise BadInput(f"{path}: there is no such file; {_AGAIN}") from None
    except OSError as error:
        raise BadInput(f"{path}: cannot be read ({error.strerror}); {_AGAIN}") from None
    except ValueError as error:  # no text, or no JSON
        raise BadInput(f"{path}: this is no JSON ({error}); {_AGAIN}") from None
    if not isinstance(found, dict) or not {"model", "effects"} <= found.keys():
        raise BadInput(f"{path}: this is no trace, it contains no model with effects; {_AGAIN}")
    return found
