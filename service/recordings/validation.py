"""Validation data: recordings that the learner never learns from, read once at the start."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.compensation.freeing import takes_torque
from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import AXES, BODY_YAW_RATE, YAW
from incsvr.signals import REQUIRED, synchronise
from incsvr.signals.samples import Samples
from service.config.configuration import Config
from service.config.traced_effects import TracedEffects


def read_validation(path: Path, config: Config, effects: TracedEffects | None = None) -> Samples:
    """The damping samples of a recording (CSV with t, yaw_rate and torque), made as the learner makes its own.

    Freed of the same effects and other velocities, of which the recording must hold the channels. Of another axis than
    yaw its own columns are taken, such as sway and sway_force, where the recording is of the whole vehicle.

    Raises:
        BadInput: naming the file and the cure.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            table: Any = np.genfromtxt(path, delimiter=",", names=True, encoding="utf-8-sig", dtype=np.float64)
    except (OSError, ValueError, UserWarning) as error:
        raise BadInput(f"{path}: this is no recording ({str(error).splitlines()[0]})") from None
    columns = _of_axis({name: np.atleast_1d(table[name]) for name in table.dtype.names or ()}, config.vehicle.axis)
    settings, coupled = config.signal_settings(), config.coupled()
    compensation = None if effects is None else effects.compensation
    further = config.further_inputs if compensation is None and coupled is None else settings.channels
    for name in ("t", *REQUIRED, *further):
        if name in further and name not in columns:
            raise BadInput(f"{path}: there is no column {name}, which every sample needs; leave this recording out")
        if name not in columns:
            raise BadInput(f"{path}: there is no column {name}; a recording has t [s], yaw_rate [rad/s], torque [N m]")
    streams = {}
    for name in (*REQUIRED, *further):
        sampled = ~np.isnan(columns[name])
        streams[name] = (columns["t"][sampled], columns[name][sampled])
    samples, rejected = synchronise(settings, streams, takes_torque(settings, compensation, coupled))
    samples = samples.take(samples.known(config.further_inputs))
    if not len(samples):
        raise BadInput(f"{path}: it yields no sample (rejected: {dict(rejected)}); is it longer than its gaps?")
    return samples


def _of_axis(columns: dict[str, Array], name: str) -> dict[str, Array]:
    """The columns of a whole vehicle with those of this axis under the two names of a learner."""
    axis = AXES[name]
    if axis == YAW or not {axis.rate, axis.effort} <= columns.keys():
        return columns
    turning = {BODY_YAW_RATE: columns[YAW.rate]} if YAW.rate in columns else {}
    return {**columns, **turning, YAW.rate: columns[axis.rate], YAW.effort: columns[axis.effort]}
