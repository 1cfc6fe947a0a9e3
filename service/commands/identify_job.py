"""The program of the process beside the page: it identifies the vehicle of one log.

`python -m service.commands.identify_job FOLDER WORD…`, with the words of `incsvr identify`.

It writes `progress.json`, and then `report.html`, `vehicle.yaml` and `result.json` into the folder. Exit status 0 done,
2 the log cannot answer (one sentence on standard error). It stands back behind everything else on the machine, and is
bounded in memory, processor time and the size of files. When the page is gone, so is this process.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from incsvr.errors import BadInput
from service.live.background import NO_ANSWER, end_with_the_parent, stand_back

NICENESS = 19
"""The lowest priority."""
MAX_PROCESSOR_S = 1800
"""Processor time of the process [s]: fifty times as much as five minutes of six axes take."""


def main(folder: Path, words: Sequence[str]) -> int:
    stand_back(NICENESS, MAX_PROCESSOR_S)
    end_with_the_parent()
    try:
        _identify(folder, words)
    except BadInput as error:
        print(error, file=sys.stderr)
        return NO_ANSWER
    except MemoryError:
        print("this log needs more memory than an identification may take; cut it with incsvr convert", file=sys.stderr)
        return NO_ANSWER
    return 0


def _identify(folder: Path, words: Sequence[str]) -> None:
    # Loaded within the bounds.
    from service.cli.parser import Parser
    from service.commands import identify
    from service.commands.report_head import REPORT_WRITER, provenance
    from service.config.vehicle_file import write_vehicle
    from service.wire.json_text import write_json

    done = 0

    def tell(step: str, count: int) -> None:
        nonlocal done
        write_json(folder / "progress.tmp", {"step": step, "done": done, "count": count + 1})
        (folder / "progress.tmp").replace(folder / "progress.json")
        done += 1

    parser = Parser(prog="incsvr identify")
    identify.add_arguments(parser)
    args = parser.parse_args(list(words))
    found, notes = identify.answer(args, tell)
    tell("writing the report", done)
    write_vehicle(folder / "vehicle.yaml", found.vehicle)
    shown = [Path(word).name if Path(word).parent != Path() else word for word in words]
    made, no_report = provenance(args, ["identify", *shown]), None
    try:
        import_module(REPORT_WRITER).write_vehicle(found, folder / "report.html", notes, made)
    except BadInput as error:  # a vehicle may lack what draws
        no_report = str(error)
    write_json(folder / "result.json", {**found.to_dict(), "notes": list(notes), "no_report": no_report})


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2:]))
