"""Checks that pip finds a wheel for aarch64 (Raspberry Pi, Jetson) of every dependency, and of those of extras.

    python deploy/aarch64.py [EXTRA…]

It asks pip's index, installs nothing, and exits with status 1 where a wheel is missing. No aarch64 machine runs it: a
wheel that is found is untested.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parent.parent
PLATFORMS = ("manylinux_2_28_aarch64", "manylinux_2_17_aarch64", "manylinux2014_aarch64")
PYTHON = "3.11"


def wheels(requirement: str) -> dict[str, str]:
    """Name and version → file of the wheel, of a requirement and of all that it needs.

    Raises:
        SystemExit: pip finds no wheel; the message is pip's.
    """
    platforms = [word for name in PLATFORMS for word in ("--platform", name)]
    with TemporaryDirectory() as folder:
        command = [
            *(sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--dry-run"),
            *("--ignore-installed", "--report", "-", "--only-binary", ":all:", "--python-version", PYTHON, *platforms),
            *("--target", folder, "--constraint", str(ROOT / "constraints.txt"), requirement),
        ]
        found = subprocess.run(command, capture_output=True, text=True, check=False)
    if found.returncode:
        raise SystemExit(f"{requirement}: {found.stderr.strip().splitlines()[-1]}")
    each = json.loads(found.stdout)["install"]
    return {
        f"{one['metadata']['name']} {one['metadata']['version']}": one["download_info"]["url"].rpartition("/")[2]
        for one in each
    }


def main(extras: list[str]) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [*project["dependencies"], *(one for name in extras for one in project["optional-dependencies"][name])]
    found = dict[str, str]()
    for requirement in wanted:
        found |= wheels(requirement)
    for name, file in sorted(found.items()):
        print(f"{name:<32} {'aarch64' if 'aarch64' in file else 'any machine'}")
    print(f"{len(found)} wheels for Python {PYTHON} on aarch64, untested there")


if __name__ == "__main__":
    main(sys.argv[1:])
