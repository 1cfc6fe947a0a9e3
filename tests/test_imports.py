"""The house's rule: who may import whom (the arrows of the structure, and nothing else)."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Collection
from functools import cache
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
        "service.cli.progress",
        "service.cli.display",
    },
    "viewer": {
        "viewer",
        "incsvr",
        "service.wire",
        "service.inputs.units",
        "service.recordings",
        "service.config",
        "service.cli.display",
        "service.cli.extras",
        "service.bus.session",
    },
}
FOREIGN = {"incsvr": {"numpy", "scipy"}}
ROOMS = (
    "errors",
    "numerics",
    "plant",
    "model",
    "signals",
    "checks",
    "learning",
    "tracing",
    "compensation",
    "forecasting",
    "vehicle",
)
"""The rooms of the mathematics, none of which imports one further down this list, not even for its types."""
SERVICE_ROOMS = (
    "number",
    "wire",
    "inputs",
    "security",
    "config",
    "cli",
    "logs",
    "state",
    "recordings",
    "learner",
    "fitting",
    "health",
    "live",
    "bus",
    "host",
    "export",
    "commands",
)
"""The rooms of the service, likewise."""


@cache
def imports_of(path: Path) -> tuple[str, ...]:
    """Every module that a file imports, wherever in the file; `from a.b import c` counts as a.b.c."""
    found: list[str] = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found += (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative imports hide the arrows"
            found += (f"{node.module}.{alias.name}" for alias in node.names)
    return tuple(found)


def allowed(module: str, prefixes: set[str]) -> bool:
    return any(module == prefix or module.startswith(prefix + ".") for prefix in prefixes)


def module_name(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def owner(imported: str, modules: Collection[str]) -> str | None:
    """The file that an import names: the module, or the one that holds the name; None where it is none of these."""
    return next((name for name in (imported, imported.rpartition(".")[0]) if name in modules), None)


@pytest.mark.parametrize("package", sorted(ALLOWED))
def test_a_package_imports_only_along_the_arrows(package: str) -> None:
    for path in sorted((ROOT / package).rglob("*.py")):
        for module in imports_of(path):
            top = module.partition(".")[0]
            if top in OURS:
                assert allowed(module, ALLOWED[package]), f"{path.relative_to(ROOT)} imports {module}"
            elif package in FOREIGN and top not in sys.stdlib_module_names:
                assert top in FOREIGN[package], f"{path.relative_to(ROOT)} imports {module}"


@pytest.mark.parametrize(("package", "rooms"), [("incsvr", ROOMS), ("service", SERVICE_ROOMS)])
def test_no_room_imports_one_below_it(package: str, rooms: tuple[str, ...]) -> None:
    for path in sorted((ROOT / package).rglob("*.py")):
        room = path.relative_to(ROOT / package).with_suffix("").parts[0]
        if room == "__init__":  # the face, which imports none of them
            continue
        above = {f"{package}.{name}" for name in rooms[: rooms.index(room) + 1]}
        for module in imports_of(path):
            assert not allowed(module, {package}) or allowed(module, above), f"{path.relative_to(ROOT)}: {module}"


def test_no_file_of_the_mathematics_imports_itself_by_way_of_others() -> None:
    paths = {module_name(path): path for path in (ROOT / "incsvr").rglob("*.py")}
    imported = {name: {owner(each, paths) for each in imports_of(path)} for name, path in paths.items()}
    while leaves := [name for name, modules in imported.items() if not modules & imported.keys()]:
        for name in leaves:
            del imported[name]
    assert not imported, f"these import each other: {sorted(imported)}"


def test_only_the_viewer_imports_rerun() -> None:
    for package in sorted(OURS - {"viewer", "tests"}):
        for path in sorted((ROOT / package).rglob("*.py")):
            assert not any(allowed(module, {"rerun"}) for module in imports_of(path)), path


def test_what_injects_an_effect_shares_nothing_with_what_finds_it() -> None:
    written_apart = ("effects.py", "second_effects.py", "physics.py")
    for path in sorted((ROOT / "simulator").glob("*.py")):
        for module in imports_of(path):
            name = f"{path.relative_to(ROOT)} imports {module}"
            if path.name in written_apart:
                assert not allowed(module, {"incsvr.plant", "incsvr.model"}), name
            if path.name != "whole_vehicle.py":  # it plays a vehicle that was identified
                assert not allowed(module, {"incsvr.model", "incsvr.tracing", "incsvr.vehicle"}), name


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


def test_the_engine_loads_neither_scipys_signals_nor_its_statistics() -> None:
    """They take 24 MB and half a second; what is loaded later filters with the same function."""
    program = (
        "import sys, numpy, incsvr.model.identification, incsvr.model.efforts\n"
        "held = {'scipy.signal', 'scipy.stats'} & set(sys.modules)\n"
        "from incsvr.numerics.linear_filter import lfilter\n"
        "import scipy.signal\n"
        "words = [0.0, 0.3], [1.0, -0.7], numpy.arange(9.0)\n"
        "same = (lfilter(*words) == scipy.signal.lfilter(*words)).all()\n"
        "sys.exit(0 if not held and same else f'{held}, {same}')"
    )
    assert subprocess.run([sys.executable, "-c", program], cwd=ROOT, check=False).returncode == 0


def test_inspecting_a_csv_loads_neither_scipy_nor_zenoh(tmp_path: Path) -> None:
    """`scipy.ndimage` alone took 11 of 76 MB. LAPACK is loaded without the rest of SciPy."""
    (tmp_path / "log.csv").write_text("t,yaw_rate,torque\n" + "".join(f"{k / 9},{k % 7},{k % 5}\n" for k in range(99)))
    program = (
        "import sys; from service.cli.command_line import main; status = main(['inspect', sys.argv[1]])\n"
        "from incsvr.numerics import lapack\n"
        "held = {name for name in sys.modules if name.partition('.')[0] in ('scipy', 'zenoh', 'rich')}\n"
        "sys.exit(status or sorted(held - {lapack.MODULE}) or 0)"
    )
    words = [sys.executable, "-c", program, str(tmp_path / "log.csv")]
    found = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stderr


def test_the_learner_process_holds_of_scipy_its_lapack_alone() -> None:
    """The rest is 25 MB and half of a start; whoever loads SciPy later gets the same LAPACK."""
    program = (
        "import sys, service.commands.serve, service.bus.mapped_ingest\n"
        "held = {name for name in sys.modules if name.partition('.')[0] == 'scipy'}\n"
        "from incsvr.numerics import lapack\n"
        "import scipy.linalg, scipy.optimize, scipy.stats\n"
        "same = scipy.linalg.lapack.dpotrf is lapack.dpotrf\n"
        "sys.exit(0 if held == {lapack.MODULE} and same else f'{held}, {same}')"
    )
    assert subprocess.run([sys.executable, "-c", program], cwd=ROOT, check=False).returncode == 0
