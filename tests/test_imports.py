"""The house's rule: who may import whom (the arrows of the structure, and nothing else)."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
OURS = {"incsvr", "service", "simulator", "viewer", "benchmarks", "tests"}
ALLOWED = {
    "incsvr": {"incsvr"},
    "service": {"service", "incsvr"},
    "simulator": {
        "simulator",
        "incsvr",
        "service.wire",
        "service.recordings",
        "service.logs",
        "service.config",
        "service.bus.session",
    },
    "viewer": {
        "viewer",
        "incsvr",
        "service.wire",
        "service.logs.picture",
        "service.recordings",
        "service.config",
        "service.cli.extras",
        "service.bus.session",
    },
}
FOREIGN = {"incsvr": {"numpy", "scipy"}}


def imports_of(path: Path) -> Iterator[str]:
    """Every module that a file imports, wherever in the file; `from a.b import c` counts as a.b.c."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative imports hide the arrows"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def allowed(module: str, prefixes: set[str]) -> bool:
    return any(module == prefix or module.startswith(prefix + ".") for prefix in prefixes)


@pytest.mark.parametrize("package", sorted(ALLOWED))
def test_a_package_imports_only_along_the_arrows(package: str) -> None:
    for path in sorted((ROOT / package).rglob("*.py")):
        for module in imports_of(path):
            top = module.partition(".")[0]
            if top in OURS:
                assert allowed(module, ALLOWED[package]), f"{path.relative_to(ROOT)} imports {module}"
            elif package in FOREIGN and top not in sys.stdlib_module_names:
                assert top in FOREIGN[package], f"{path.relative_to(ROOT)} imports {module}"


def test_what_is_measured_knows_no_logs() -> None:
    """Logs are read by the mapping of inputs, and not the other way round."""
    for path in sorted((ROOT / "service" / "inputs").rglob("*.py")):
        for module in imports_of(path):
            assert not allowed(module, {"service.logs"}), f"{path.relative_to(ROOT)} imports {module}"


def test_only_the_viewer_imports_rerun() -> None:
    for package in sorted(OURS - {"viewer", "tests"}):
        for path in sorted((ROOT / package).rglob("*.py")):
            assert not any(allowed(module, {"rerun"}) for module in imports_of(path)), path


def test_what_injects_an_effect_shares_nothing_with_what_finds_it() -> None:
    injecting = [*(ROOT / "simulator" / "effects").rglob("*.py"), ROOT / "simulator" / "missions" / "hidden.py"]
    for path in sorted(injecting):
        for module in imports_of(path):
            assert not allowed(module, {"incsvr"}), f"{path.relative_to(ROOT)} imports {module}"


def test_the_mathematics_has_no_clock_and_no_files() -> None:
    forbidden = {"time", "datetime", "pathlib", "os", "io", "socket", "threading", "subprocess", "pydantic"}
    for path in sorted((ROOT / "incsvr").rglob("*.py")):
        for module in imports_of(path):
            assert module.partition(".")[0] not in forbidden, f"{path.relative_to(ROOT)} imports {module}"


def test_the_learner_process_never_holds_rerun() -> None:
    program = (
        "import sys, service.commands.serve; sys.exit(any(name.partition('.')[0] == 'rerun' for name in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", program], cwd=ROOT, check=False).returncode == 0
