"""The settings of a fit, in their order: those scaled to the log, over them those of a file, over them those set."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import Any

from incsvr.signals import SignalSettings
from service.config.configuration import Config
from service.config.sources import sections
from service.config.traced_effects import TracedEffects, configured_effects, read_effects
from service.fitting.declared import Declared
from service.fitting.request import Request
from service.fitting.scaled import three_digits
from service.fitting.terms import SMOOTHING, Terms, over_scaled
from service.recordings.recording import Recording
from service.recordings.samples_from_recording import signals_for

OF_NO_RECORDING = {"policy", "solver", "capacity", "batch", "fastest"}
"""The settings of a learner that no recording decides."""
OF_THE_BUS = {SMOOTHING, "sample_period", "lateness", "gap", "channels", "rate_limit", "torque_limit"}
"""The settings of signals that hold as they are set; what the torque is decides how they are scaled."""


def as_configured(request: Request) -> bool:
    """Whether a file says how to learn; one that says only what is in a log leaves the scales to the recordings."""
    return request.config is not None and not sections(request.config) <= {"inputs"}


def settings(
    request: Request, config: Config, declared: Declared, runs: Sequence[Recording], unseen: Sequence[Recording]
) -> tuple[SignalSettings, Terms]:
    """The signal settings, and what all attempts on these recordings have in common.

    Args:
        config: the file's, with what is set.
        declared: the vehicle.

    Raises:
        BadInput: the traced effects cannot be used with them.
    """
    by_file, coupled, axis = as_configured(request), declared.coupled, runs[0].axis
    chosen: dict[str, Any] = {} if request.policy is None else {"policy": request.policy}
    effects: TracedEffects | None = None
    if by_file:
        wanted = declared.in_force(config)
        if request.effects:
            wanted = wanted.model_copy(update={"effects": request.effects})
        signals, learner, effects = wanted.signal_settings(), wanted.learner_settings(), configured_effects(wanted)
        by_person = frozenset(config.signals.model_fields_set)
    else:
        learner, by_person = None, request.names_set("signals")
        chosen = _of_a_person(request, config) | chosen
        signals = three_digits(signals_for(runs, declared.inertia, axis.fastest, declared.torque))
        names = (request.names_set("signals") | request.names_set("vehicle")) & OF_THE_BUS
        signals = over_scaled(signals, {name: getattr(config.signal_settings(), name) for name in names})
        path = request.effects or config.effects
        if path is not None:
            common = tuple(name for name in runs[0].channels if all(name in run.channels for run in (*runs, *unseen)))
            effects = read_effects(path, declared.inertia, common, coupled)
            signals = replace(signals, channels=effects.compensation.reads(common))
    streams = () if coupled is None else coupled.streams
    signals = replace(signals, channels=tuple(dict.fromkeys((*signals.channels, *streams))))
    set_ = frozenset(name for name in by_person if getattr(config.signals, name) is not None)
    inputs = config.further_inputs
    return signals, Terms(learner, chosen, effects, coupled, inputs, request.assume_sign, axis, set_)


def _of_a_person(request: Request, config: Config) -> dict[str, Any]:
    """The settings of the learner that no recording decides, and those that are set."""
    known = asdict(config.learner_settings())
    names = OF_NO_RECORDING | request.names_set("learner") | request.names_set("vehicle")
    return {name: known[name] for name in names & known.keys()}
