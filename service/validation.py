"""Validation data: recordings that the learner never learns from, read once at the start."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.samples import Samples
from incsvr.signals import REQUIRED, SignalSettings, synchronise


def read_validation(path: Path, settings: SignalSettings) -> Samples:
    """The damping samples of a recording (CSV with t, yaw_rate and torque), made as the learner makes its own.

    Raises:
        BadInput: naming the file and the cure.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            table: Any = np.genfromtxt(path, delimiter=",", names=True, encoding="utf-8-sig", dtype=np.float64)
    except (OSError, ValueError, UserWarning) as error:
        raise BadInput(f"{path}: this is no recording ({str(error).splitlines()[0]})") from None
    columns = {name: np.atleast_1d(table[name]) for name in table.dtype.names or ()}
    for name in ("t", *REQUIRED):
        if name not in columns:
            raise BadInput(f"{path}: there is no column {name}; a recording has t [s], yaw_rate [rad/s], torque [N m]")
    streams = {}
    for name in REQUIRED:
        sampled = ~np.isnan(columns[name])
        streams[name] = (columns["t"][sampled], columns[name][sampled])
    samples, rejected = synchronise(settings, streams)
    if not len(samples):
        raise BadInput(
            f"{path}: no sample could be made of it (rejected: {dict(rejected)}); is it longer than its gaps?"
        )
    return samples
