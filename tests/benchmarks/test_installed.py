"""What of the benchmarks is installed on a vehicle: what the commands of `incsvr` import, and nothing else."""

from __future__ import annotations

import ast
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from service.cli.command_line import COMMANDS

ROOT = Path(__file__).resolve().parents[2]


def file_of(module: str) -> Path:
    return ROOT.joinpath(*module.split(".")).with_suffix(".py")


def needed_by(module: str) -> Iterator[str]:
    """Modules of the benchmarks that one imports, or starts as a process by its name."""
    for node in ast.walk(ast.parse(file_of(module).read_text(encoding="utf-8"))):
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [str(node.module), *(f"{node.module}.{alias.name}" for alias in node.names)]
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            names = [node.value]
        yield from (name for name in names if name.startswith("benchmarks.") and file_of(name).is_file())


def test_a_wheel_holds_what_commands_import_of_the_benchmarks_and_nothing_else() -> None:
    setuptools: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"][
        "setuptools"
    ]
    waiting = [module for module, *_ in COMMANDS.values() if module.startswith("benchmarks.")]
    assert waiting
    needed = set[str]()
    while waiting:
        if (module := waiting.pop()) not in needed:
            needed.add(module)
            waiting += needed_by(module)
    assert sorted(setuptools["py-modules"]) == sorted(needed)
    assert not [pattern for pattern in setuptools["packages"]["find"]["include"] if pattern.startswith("bench")]
