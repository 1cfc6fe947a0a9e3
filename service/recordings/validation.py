"""Validation data: recordings that the learner never learns from, read once at the start."""

from __future__ import annotations

from pathlib import Path

from incsvr.compensation.freeing import takes_torque
from incsvr.errors import BadInput
from incsvr.plant.axes import AXES
from incsvr.signals import REQUIRED, synchronise
from incsvr.signals.samples import Samples
from service.config.configuration import Config
from service.config.traced_effects import TracedEffects


def read_validation(path: Path, config: Config, effects: TracedEffects | None = None) -> Samples:
    """The damping samples of a log of any format, made as the learner makes its own.

    Freed of the same effects and other velocities, of which the log must hold the channels. A log of others is read by
    the configured inputs; of another axis than yaw its own columns are taken, such as sway and sway_force.

    Raises:
        BadInput: naming the file and the cure.
    """
    # Loaded where it is needed alone: most learners validate on nothing.
    from service.logs.own_table import is_ours
    from service.recordings.reading import Reading

    reading = Reading.configured(config)
    if is_ours(path, AXES[config.vehicle.axis]):
        reading = reading.undescribed
    streams = reading.of_one(path).streams()
    settings, coupled = config.signal_settings(), config.coupled()
    compensation = None if effects is None else effects.compensation
    further = config.further_inputs if compensation is None and coupled is None else settings.channels
    for name in further:
        if name not in streams:
            raise BadInput(f"{path}: there is no channel {name}, which every sample needs; leave this recording out")
    wanted = {name: streams[name] for name in (*REQUIRED, *further)}
    samples, rejected = synchronise(settings, wanted, takes_torque(settings, compensation, coupled))
    samples = samples.take(samples.known(config.further_inputs))
    if not len(samples):
        raise BadInput(f"{path}: it yields no sample (rejected: {dict(rejected)}); is it longer than its gaps?")
    return samples
