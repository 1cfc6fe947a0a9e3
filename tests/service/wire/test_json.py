"""Every JSON that is written is valid: where there is no number in a result, or in a payload, there is null."""

from __future__ import annotations

import copy
import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from service import wire
from service.cli.command_line import main
from service.recordings.recording_csv import write
from service.wire.json_text import json_text
from tests.worlds import trial

ROOT = Path(__file__).resolve().parents[3]
NO_NUMBERS = (math.nan, math.inf, -math.inf)
LATEST = ("table1", "bench")
OTHERWISE = {
    "service/wire/json_text.py": "the place itself",
    "service/config/traced_effects.py": "a checksum of effects, not written as JSON",
    "service/inputs/forms/json5.py": "a token of JSON5 as JSON spells it",
    "service/state/restored.py": "refuses a memory that holds what is no number",
}
"""Who calls json.dumps beside the one place that writes, and why."""

Place = tuple[str | int, ...]


def strict(text: str | bytes) -> Any:
    """The value as a reader takes it that goes by RFC 8259."""

    def refuse(word: str) -> float:
        raise AssertionError(f"{word} is no JSON")

    return json.loads(text, parse_constant=refuse)


def numbers(value: Any, at: Place = ()) -> Iterator[Place]:
    """Where the numbers are; of a list of plain ones the first stands for all."""
    if isinstance(value, dict):
        for key, each in value.items():
            yield from numbers(each, (*at, key))
    elif isinstance(value, list | tuple):
        plain = all(isinstance(each, float) for each in value)
        for k, each in enumerate(value[:1] if plain else value):
            yield from numbers(each, (*at, k))
    elif isinstance(value, float):
        yield at


def put(value: Any, at: Place, number: float | None) -> Any:
    changed = copy.deepcopy(value)
    inner = changed
    for key in at[:-1]:
        inner = inner[key]
    inner[at[-1]] = number
    return changed


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What commands write of a small recording, and the last results of those that take minutes."""
    folder = tmp_path_factory.mktemp("json")
    outcome, log = trial(3, duration=60.0), folder / "log.csv"
    write(log, outcome.recording)
    write(folder / "unseen.csv", trial(4, duration=60.0).recording)
    inertia = ("--inertia", str(outcome.inertia))
    commands = {
        "trace": (str(log), *inertia),
        "fit": (str(log), *inertia, "--validate", str(folder / "unseen.csv")),
        "inspect": (str(log),),
        "config show": (),
    }
    for name, words in commands.items():
        assert main([*name.split(), *words, "--json", str(folder / f"{name}.json")]) == 0
    found = {name: strict((folder / f"{name}.json").read_bytes()) for name in commands}
    published = {name: strict((ROOT / "benchmarks/results" / f"{name}.json").read_bytes()) for name in LATEST}
    return found | published


@pytest.mark.slow
def test_what_is_no_number_in_any_field_of_any_result_is_null(results: dict[str, Any]) -> None:
    for name, result in results.items():
        places = list(numbers(result))
        assert places, name
        for k, at in enumerate(places[:400]):
            assert strict(json_text(put(result, at, NO_NUMBERS[k % 3]))) == put(result, at, None), (name, at)


@pytest.mark.parametrize("form", [each for each in vars(wire).values() if isinstance(each, type)], ids=str)
def test_what_is_no_number_in_any_field_of_any_payload_is_null(form: type) -> None:
    if not issubclass(form, wire.Form):
        pytest.skip("no payload")
    for field in form.model_fields:
        for number in NO_NUMBERS:
            for value, expected in (
                (number, None),
                ((1.0, number), [1.0, None]),
                ({"a": {"b": number}}, {"a": {"b": None}}),
            ):
                assert (
                    strict(form.model_construct(None, **{field: value}).model_dump_json(warnings=False))[field]
                    == expected
                )


def test_numbers_of_numpy_are_numbers() -> None:
    assert strict(json_text({"a": np.float32(0.5), "b": np.arange(2), "c": np.array([1.0, np.nan])})) == {
        "a": 0.5,
        "b": [0, 1],
        "c": [1.0, None],
    }


def test_nobody_else_writes_json() -> None:
    writers = set()
    for package in ("incsvr", "service", "simulator", "viewer", "benchmarks"):
        for path in (ROOT / package).rglob("*.py"):
            if re.search(r"\bjson\.dumps?\(", path.read_text(encoding="utf-8")):
                writers.add(str(path.relative_to(ROOT)))
    assert writers == set(OTHERWISE)
