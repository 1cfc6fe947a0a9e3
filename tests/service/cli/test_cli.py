"""The command line: one sentence for what is wrong, what was meant, and nothing found out late."""

from __future__ import annotations

import re
import shlex
import subprocess
import tomllib
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

import pytest

from service.cli import extras
from service.cli.command_line import COMMANDS, main, whole_parser
from service.cli.parser import REMOVED
from tests.conftest import ROOT

EXAMPLES = [(name, example) for name, (_, _, example) in COMMANDS.items()]


@pytest.fixture
def said(capsys: pytest.CaptureFixture[str]) -> Iterator[object]:
    """What a command line is answered with: its exit status, and what stands on standard error."""

    def ask(line: str) -> str:
        try:
            status: object = main(shlex.split(line))
        except SystemExit as end:
            status = end.code
        return f"{status} {capsys.readouterr().err}"

    return ask  # type: ignore[return-value]


def test_it_says_its_version(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["--version"])
    assert end.value.code == 0
    assert capsys.readouterr().out == f"incsvr {version('incsvr')}\n"


@pytest.mark.parametrize(("name", "example"), EXAMPLES)
def test_the_help_of_every_command_ends_with_an_example_that_parses(
    name: str, example: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main([name, "--help"])
    assert capsys.readouterr().out.endswith(f"example:\n  {example}\n")
    monkeypatch.chdir(tmp_path)
    words = shlex.split(example.partition(" > ")[0])
    assert words[:2] == ["incsvr", name]
    assert whole_parser().parse_args(words[1:]).command == name


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("trcae", "incsvr: there is no command trcae; did you mean trace?"),
        ("frobnicate", "incsvr: there is no command frobnicate; `incsvr --help` lists all"),
        ("config chekc", "incsvr config: there is no command chekc; did you mean check?"),
        ("fit x.csv --polcy paper", "incsvr fit: there is no flag --polcy; did you mean --policy?"),
        ("query 0.1 --zzz", "incsvr query: there is no flag --zzz; `incsvr query --help` lists all"),
        ("fit x.csv --policy weigted", "--policy takes paper or weighted, not weigted; did you mean weighted?"),
        ("replay x.csv --speed fast", "incsvr replay: --speed takes a number, not fast"),
        ("table1 --seeds 1.5", "incsvr table1: --seeds takes a whole number, not 1.5"),
        ("fit", "incsvr fit: RECORDING is missing, as in `incsvr fit dive.csv"),
        ("fit x.csv --inertia", "incsvr fit: --inertia needs a value"),
        ("compare --from-learner state", "incsvr compare: --from-learner was removed; compare the logs of the dives"),
        ("status now", "incsvr status: unexpected argument 'now'"),
        *(
            (f"{name} {flag}".removeprefix("incsvr "), f"{name}: {flag} was removed; ".removeprefix("incsvr "))
            for name, flag in REMOVED
        ),
        ("inspect", "incsvr inspect: name a log, or inspect the vehicle's bus with --bus"),
        ("inspect x.csv --ask 3", "--ask asks a vehicle on the bus; add --bus and leave out the log"),
        ("inspect x.csv --bus", "x.csv: inspect either this log or, with --bus, the vehicle's bus"),
        ("inspect --bus --to 3", "incsvr inspect: --to is about a log; leave it out with --bus"),
        ("inspect --bus --preset ros2", "incsvr inspect: with --bus write --set inputs.preset=ros2"),
        ("status --follow --json -", "incsvr status: --follow shows a screen; leave out --json"),
    ],
)
def test_what_is_wrong_is_one_sentence(said: object, line: str, sentence: str) -> None:
    answer = said(line)  # type: ignore[operator]
    assert answer.startswith("2 ")
    assert sentence in answer
    assert answer.count("\n") == 1
    assert "usage" not in answer


@pytest.mark.parametrize(
    "value",
    [
        "bus.listen=7447:tcp",
        "bus.connect=somewhere",
        "prefix='a b'",
        "vehicle.name=Ü",
        "inputs.yaw_rate={topic: imu, form: cdr}",
    ],
)
def test_nobody_is_shown_a_regular_expression(said: object, value: str) -> None:
    answer = said(f'config show --set "{value}"')  # type: ignore[operator]
    assert answer.startswith(f"2 incsvr config: --set {value.partition('=')[0]}")
    assert not re.search(r"[\\^$|]|\[A-Z|pattern", answer)


@pytest.mark.parametrize("flag", ["fit --json", "trace --json", "trace --report", "query 0.1 --json"])
@pytest.mark.parametrize("target", ["nowhere/result", "."])
def test_what_cannot_be_written_is_said_before_the_work(
    said: object, flag: str, target: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = said(f"{flag} {target} {'' if 'query' in flag else 'missing.csv'}")  # type: ignore[operator]
    # The recording is missing as well: the target is looked at first.
    assert answer.startswith("2 ")
    assert ("there is no folder nowhere" in answer) == (target != ".")
    assert ("is a folder" in answer) == (target == ".")


def test_a_shell_understands_its_completion(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", "bash"]) == 0
    (tmp_path / "incsvr").write_text(capsys.readouterr().out, encoding="utf-8")
    ask = 'source ./incsvr; COMP_WORDS=(incsvr fit --val); COMP_CWORD=2; _shtab_incsvr; echo "${COMPREPLY[*]}"'
    completed = subprocess.run(["bash", "-c", ask], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert completed.stdout.split() == ["--validate"]


@pytest.mark.parametrize(
    ("module", "extra"), [("rerun", "viewer"), ("jinja2", "report"), ("google.protobuf", "logs"), ("sklearn", "bench")]
)
def test_what_installs_a_missing_package_is_an_extra_that_holds_it(module: str, extra: str) -> None:
    named = extras.how_to_install(module)
    assert named.startswith(f"pip install '.[{extra}]' in the checkout")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    listed = re.findall(r"'([^']+)'", named.partition("or pip install")[2])
    # The metadata sort what a requirement's brackets and bounds hold in their own way: names are what counts.
    names = [re.split(r"[^\w-]", each)[0].lower() for each in project["optional-dependencies"][extra]]
    assert [re.split(r"[^\w-]", each)[0].lower() for each in listed] == names


def test_every_package_is_typed() -> None:
    for package in ("incsvr", "service", "simulator", "viewer", "benchmarks"):
        assert (ROOT / package / "py.typed").is_file()
