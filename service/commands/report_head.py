"""The head of a report: its data, settings and versions, so that the file explains itself."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version

REPORT_WRITER = "viewer.report"
"""Writes a report; loaded when asked for, so that learning and tracing need no drawing library."""
PLOTS = "viewer.plots"
"""Draws figures; loaded when asked for."""


def provenance(args: argparse.Namespace, words: Sequence[str] | None = None) -> dict[str, str]:
    """Recordings, command line (`words`, or those of this process), software and date, each by what to call it."""
    named = {"recordings": args.recordings, "validated on": args.validate}
    return {
        **{name: ", ".join(path.name for path in paths) for name, paths in named.items() if paths},
        "command": shlex.join(["incsvr", *(sys.argv[1:] if words is None else words)]),
        "software": f"incsvr {version('incsvr')}, numpy {version('numpy')}, scipy {version('scipy')}",
        "date": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    }
