"""Where and when a figure was measured: no figure is published without it; and the two files of a study."""

from __future__ import annotations

import importlib.metadata
import os
import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from service.wire.json_text import json_text

RESULTS = Path(__file__).parent / "results"
"""Where the pages of the published results are."""
MEASURED = Path(__file__).parents[2] / "shared" / "measured"
"""The recordings of measured vehicles carry no licence, so that they stand beside the project and not in it."""


def provenance(command: str, *packages: str) -> dict[str, object]:
    """Command, date, machine and the versions of what was measured."""
    return {
        "command": command,
        "date": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "processor": _processor(),
        "cores": os.cpu_count(),
        "load_before": os.getloadavg()[0],
        "python": platform.python_version(),
        "versions": {name: importlib.metadata.version(name) for name in ("numpy", "scipy", *packages)},
    }


def publish(folder: Path, name: str, document: Mapping[str, Any], text: str) -> None:
    """Writes a study for programs (`name.json`) and for people (`name.md`), and prints the latter."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.json").write_text(json_text(document, indent=1) + "\n", encoding="utf-8")
    (folder / f"{name}.md").write_text(text, encoding="utf-8")
    print(text)


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())
