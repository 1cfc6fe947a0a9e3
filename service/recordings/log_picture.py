"""`incsvr view LOG`: reads a log and makes the samples of it that `fit` would learn from."""

from __future__ import annotations

import argparse
from dataclasses import replace

from incsvr.errors import BadInput
from incsvr.plant.words import words_of
from service.cli.progress import progress
from service.config.configuration import Config
from service.config.sources import read as read_config
from service.logs.picture import LogPicture
from service.recordings.declared_inertia import inertia
from service.recordings.reading import Reading, add_log_arguments
from service.recordings.recording import Recording
from service.recordings.samples_from_recording import learner_for, samples_of, signals_for

ASK_INERTIA = "No damping samples without the {inertia}: --inertia I [{inertia_unit}], or --inertia estimate."
"""The request for the inertia: a template of `AxisWords`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--inertia", metavar="I", help="for a log: inertia with added mass [kg m²], or estimate")
    add_log_arguments(parser)


def picture(args: argparse.Namespace) -> LogPicture:
    """The streams of the log that `args` name, and its samples where the inertia is known.

    Raises:
        BadInput: the log cannot be read.
    """
    config = read_config(args.config)
    reading = Reading.of(args, config)
    recording = replace(reading, learns=False).of_one(args.recording)
    streams = {name: stream for name, stream in recording.streams().items() if stream[0].size}
    bare = LogPicture(recording.name, reading.axis, streams, recording.units, None, 0, recording.notes)
    of_file = config if args.config else None
    if args.inertia is None and (of_file is None or not of_file.vehicle.inertia_said):
        return replace(bare, remarks=(*bare.remarks, words_of(bare.axis).fill(ASK_INERTIA)))
    try:
        return _with_samples(bare, args, of_file, reading.of_one(args.recording))
    except BadInput as error:
        return replace(bare, remarks=(*bare.remarks, str(error)))


def _with_samples(
    bare: LogPicture, args: argparse.Namespace, config: Config | None, recording: Recording
) -> LogPicture:
    """The picture with the samples that are learned from."""
    words = words_of(bare.axis)
    declared, estimate = inertia(args.inertia, config, [recording])
    signals = signals_for([recording], declared, recording.axis.fastest, None)
    with progress("making samples"):
        samples, _ = samples_of(recording, signals, None)
    remarks = (
        f"{len(samples)} samples, one every {signals.sample_period:.3g} s, smoothed over {signals.smoothing:.3g} s, "
        f"with {words.inertia_symbol} = {declared:.4g} {words.inertia_unit}{' (estimated)' if estimate else ''}.",
    )
    batch = learner_for(samples).batch
    notes = dict.fromkeys((*remarks, *bare.remarks, *recording.notes))
    return replace(bare, samples=samples, batch=batch, remarks=tuple(notes))
