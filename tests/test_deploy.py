"""What deploy/ holds: labels that BlueOS can read, configurations that are good, and a container's start as it is."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import pytest
import yaml

from service.bus.session import free_endpoint, listener_config_at, open_session
from service.cli.command_line import whole_parser
from service.config.sources import read
from tests.conftest import ROOT

BLUEOS = ROOT / "deploy" / "blueos"
DOCKERFILE = (BLUEOS / "Dockerfile").read_text(encoding="utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
PATIENCE = 180.0


@pytest.fixture(scope="module")
def labels() -> dict[str, str]:
    """The labels, as Docker's parser has them: a shell's word each."""
    text = DOCKERFILE.replace("\\\n", "")
    found = re.findall(r"^LABEL (\w+)=(.*)$", text, re.MULTILINE)
    said = {name: subprocess.run(["sh", "-c", f"printf %s {word}"], stdout=subprocess.PIPE) for name, word in found}
    return {name: each.stdout.decode() for name, each in said.items()}


def test_the_labels_are_those_that_blueos_reads(labels: dict[str, str]) -> None:
    read_by_blueos = {"version", "permissions", "authors", "company", "readme", "links", "type", "tags", "requirements"}
    assert set(labels) == read_by_blueos
    assert labels["version"] == PROJECT["version"]
    permissions = json.loads(labels["permissions"])
    assert permissions["HostConfig"]["NetworkMode"] == "host"
    assert permissions["HostConfig"]["Binds"] == ["/usr/blueos/extensions/incsvr:/data"]
    assert {"name", "email"} <= set(json.loads(labels["authors"])[0])
    assert {"name", "email", "about"} <= set(json.loads(labels["company"]))
    assert (ROOT / json.loads(labels["links"])["documentation"]).is_file()
    assert (ROOT / labels["readme"]).is_file()
    assert json.loads(labels["tags"])


def test_what_the_image_copies_is_there_and_let_through() -> None:
    copied = re.findall(r"deploy/blueos/[\w.]+", DOCKERFILE)
    assert copied
    assert all((ROOT / path).is_file() for path in copied)
    through = {
        line.removeprefix("!").partition("/*")[0]
        for line in (BLUEOS / "Dockerfile.dockerignore").read_text(encoding="utf-8").splitlines()
        if line.startswith("!")
    }
    packages = {"incsvr", "service", "simulator", "viewer", "benchmarks"}
    assert packages | {"pyproject.toml", "constraints.txt", "README.md", "LICENSE", "deploy/blueos"} <= through


SCRIPTS = ("incsvr.service", "blueos/start.sh", "blueos/Dockerfile", "compose/compose.yaml")
COMMAND = re.compile(
    r"""(?:^|[\s="/])incsvr[ ]((?:config|serve|page|simulate|status|view)\b[^&|;>\n]*)""", re.MULTILINE
)


def test_every_command_in_a_file_parses() -> None:
    found = {name: COMMAND.findall((ROOT / "deploy" / name).read_text(encoding="utf-8")) for name in SCRIPTS}
    assert {name for name, commands in found.items() if commands} >= {"incsvr.service", "blueos/start.sh"}
    for command in (each for commands in found.values() for each in commands):
        whole_parser().parse_args(re.sub(r"\$\{[^}]*\}|\$\w+", "1", command).replace('"', "").split())


CONFIGURATIONS = sorted(path.relative_to(ROOT).as_posix() for path in ROOT.glob("deploy/**/*.yaml"))


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_every_configuration_is_good(name: str) -> None:
    path = ROOT / name
    if path.name == "compose.yaml":
        services: dict[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))["services"]
        assert (path.parent / services["learner"]["build"]["context"] / "deploy/blueos/Dockerfile").is_file()
        assert (path.parent / "config.yaml").is_file()
        whole_parser().parse_args(services["simulate"]["entrypoint"][1:])
    else:
        assert read(path).prefix


@pytest.fixture
def router() -> Iterator[str]:
    """A Zenoh router as BlueOS runs one."""
    endpoint = free_endpoint()
    with open_session(listener_config_at(endpoint)):
        yield endpoint


def test_a_container_starts_learns_of_the_vehicles_router_and_ends(router: str, tmp_path: Path) -> None:
    port = free_endpoint().rpartition(":")[2]
    config = (BLUEOS / "config.yaml").read_text(encoding="utf-8").replace("tcp/127.0.0.1:7447", router)
    (tmp_path / "config.yaml").write_text(config, encoding="utf-8")
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
        "DATA": str(tmp_path),
        "PAGE_HOST": "127.0.0.1",
        "PAGE_PORT": port,
    }
    # A process group of its own: in a container Docker ends all of them with the first.
    with subprocess.Popen(["sh", BLUEOS / "start.sh"], env=environment, start_new_session=True) as started:
        try:
            until = time.monotonic() + PATIENCE
            healthy = [sys.executable, str(BLUEOS / "healthy.py")]
            while subprocess.run(healthy, env=environment, capture_output=True).returncode != 0:
                assert started.poll() is None
                assert time.monotonic() < until, "the learner does not come to answer its page"
            with urlopen(f"http://127.0.0.1:{port}/state.json", timeout=PATIENCE) as answer:
                state = json.load(answer)
            with urlopen(f"http://127.0.0.1:{port}/register_service", timeout=PATIENCE) as answer:
                assert {"name", "description", "icon", "company", "version", "webpage", "api"} <= set(json.load(answer))
            assert state["prefix"] == "bluerov/yaw"
            assert state["away"] is None
            os.kill(started.pid, signal.SIGTERM)
            assert started.wait(PATIENCE) == 0
        finally:
            os.killpg(started.pid, signal.SIGKILL)
    assert (tmp_path / "state").is_dir()
    assert [path.name for path in (tmp_path / "archive").iterdir()] == ["bluerov-yaw_000001.mcap"]
