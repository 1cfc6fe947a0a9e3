"""What a command prints: a text for people, or one JSON object for programs (CONTRACT, Section 3)."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def add_json_argument(parser: argparse.ArgumentParser) -> None:
    """Adds `--json`: `-` for standard output, else a file."""
    parser.add_argument("--json", metavar="FILE", help="write the result as one JSON object; - for standard output")


def emit(args: argparse.Namespace, result: Mapping[str, Any], text: str) -> None:
    """Prints `text` for people and, where `--json` was given, writes `result` for programs.

    With `--json -` standard output carries the JSON object alone, and the text goes to standard error.
    """
    target: str | None = args.json
    print(text, file=sys.stderr if target == "-" else sys.stdout)
    if target is None:
        return
    document = json.dumps(result, indent=2, allow_nan=False, ensure_ascii=False)
    if target == "-":
        print(document)
    else:
        Path(target).write_text(document + "\n", encoding="utf-8")
