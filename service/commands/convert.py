"""`incsvr convert`: converts logs of any format to one CSV recording."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

from incsvr.errors import BadInput
from service.cli.output import add_json_argument, emit, refuse_unwritable, writing
from service.config.sources import read as read_config
from service.logs.cutting import ARMED_CHANNEL
from service.recordings.reading import Reading, add_log_arguments
from service.recordings.recording import Recording, sequence
from service.recordings.recording_csv import write


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="logs of any format, then the CSV to write")
    add_log_arguments(parser, config=True, axis=False)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    *logs, out = args.files
    if not logs:
        raise BadInput(f"{out}: name the logs first, then the CSV to write")
    if out.suffix != ".csv" or out in logs:
        raise BadInput(f"{out}: the last file is the one that is written; name it as in `convert {logs[0]} run.csv`")
    refuse_unwritable(out)
    reading = replace(Reading.of(args, read_config(args.config)), learns=False)
    runs = reading.of_all(logs)
    joined = runs[0] if len(runs) == 1 else sequence(runs)
    with writing(out):
        write(out, joined)
    emit(args, _result(joined, out), _text(joined, out, [note for run in runs for note in run.notes]))
    return 0


def _result(recording: Recording, out: Path) -> dict[str, object]:
    counts = {name: int(time.size) for name, (time, _) in recording.streams().items()}
    return {"file": str(out), "rows": int(recording.time.size), "values": counts, "notes": list(recording.notes)}


def _text(recording: Recording, out: Path, notes: list[str]) -> str:
    lines = [f"{out}: {recording.time.size} rows, {float(recording.time[-1] - recording.time[0]):.4g} s"]
    for name, (time, values) in recording.streams().items():
        span = f"{values.min():.4g} to {values.max():.4g}" if values.size else "nothing"
        lines.append(f"  {name:<20} {time.size:8d} values  {span}")
    if ARMED_CHANNEL in recording.columns:
        lines.append("  `fit` and `tune` use only the samples where armed is 1")
    return "\n".join([*lines, *(f"  note: {note}" for note in notes)])
