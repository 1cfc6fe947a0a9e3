"""YAML by the core schema of YAML 1.2: no word becomes a number, no name counts twice, no file takes long."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
import yaml

from incsvr.errors import BadInput
from service.config import core_yaml
from service.config.core_yaml import parse
from service.config.sources import read

LAUGHS = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{name}: &{name} [{', '.join([f'*{before}'] * 9)}]\n" for before, name in zip("abcdefgh", "bcdefghi", strict=True)
)
DEEP = "nested more than 20 deep"


@pytest.mark.parametrize(
    ("text", "means"),
    [
        ("0350", 350), ("012", 12), ("-7", -7), ("0o17", 15), ("0x1F", 31), ("1e3", 1000.0), (".5", 0.5), ("1.", 1.0),
        ("yes", "yes"), ("no", "no"), ("on", "on"), ("off", "off"), ("y", "y"), ("1:30", "1:30"), ("0b1", "0b1"),
        ("2026-11-27", "2026-11-27"), ("1_000", "1_000"), ("true", True), ("FALSE", False), ("~", None), ("", None),
        ("'350'", "350"), ("'null'", "null"), ("-.inf", -float("inf")), ("&a [1, 2]", [1, 2]),
    ],
)  # fmt: skip
def test_a_value_means_what_yaml_1_2_says(text: str, means: object) -> None:
    found = parse(text, "a text").value
    assert (found, type(found)) == (means, type(means))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("inertia: 0350", None),
        ("capacity: 012", None),
        ("inertia: yes", "line 2: vehicle.inertia: Input should be a valid number, unable to parse string as a number"),
        ("inertia: true", "line 2: vehicle.inertia: give a number, a text or a list, not true"),
        ("rate_range: [false, true]", "line 2: vehicle.rate_range: give a number"),
        ("lateness: off", "line 2: signals.lateness: Input should be a valid number"),
        ("name: 0350", "line 2: vehicle.name: Input should be a valid string, not 350; write a text in quotes"),
        ("inertia: 1\n  name: a\n  'inertia': 2", "line 4: inertia is given here and in line 2; keep one of them"),
        ("{inertia: 1, inertia: 1}", "line 2: inertia is given here and in line 2"),
        ("? [inertia]\n  : 1", "line 2: a name is a text; write `name: value`"),
        (
            "inertia: !!python/object:os.system x",
            "line 2: the tag tag:yaml.org,2002:python/object:os.system is not read",
        ),
        ("<<: {inertia: 1}", "line 2: there is no vehicle.<<; "),
        ("inertia: *rov", "line 2: this is no YAML: found undefined alias"),
        ("rate_range: &a [*a]", f"line 2: lists and sections are {DEEP}"),
        (
            "inertia: 1\n---\nvehicle: {}",
            "line 3: this is no YAML: expected a single document in the stream but found another document",
        ),
        ("inertia: 1\0", "line 2: this is no YAML: "),
    ],
)
def test_a_file_is_read_or_refused_with_its_line(tmp_path: Path, text: str, sentence: str | None) -> None:
    path = tmp_path / "config.yaml"
    section = {"capacity": "learner", "lateness": "signals"}.get(text.partition(":")[0], "vehicle")
    path.write_text(f"{section}:\n  {text}\n")
    if sentence is None:
        config = read(path)
        assert (config.vehicle.inertia, config.learner.capacity) in ((350.0, 60), (350.0, 12))
        return
    with pytest.raises(BadInput) as refused:
        read(path)
    assert str(refused.value).startswith(f"{path}, {sentence}")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("parser", [yaml.SafeLoader, getattr(yaml, "CSafeLoader", yaml.SafeLoader)])
@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (LAUGHS, "more than 50000 values"),
        ("a: " + "[" * 50_000, DEEP),
        ("{a: " * 50_000, DEEP),
        ("- " * 50_000, DEEP),
        ("a: &a [[[[[[[[[1]]]]]]]]]\nb: &b [[[[[[[[[[[[*a]]]]]]]]]]]]\n", DEEP),
        ("x" * 3_000_000, "larger than 1 MB"),
        (f"a: {'9' * 5000}", "too many digits"),
        (f"a: &a {'x' * 900_000}\nb: [{', '.join(['*a'] * 100)}]", "more than 50000 values"),
    ],
    ids=["laughs", "lists", "sections", "dashes", "aliases", "large", "digits", "long text"],
)
def test_what_has_no_end_is_refused_within_a_second(
    monkeypatch: pytest.MonkeyPatch, parser: type, text: str, sentence: str
) -> None:
    monkeypatch.setattr(core_yaml, "_LOADER", parser)
    began = time.process_time()
    with pytest.raises(BadInput, match=sentence):
        parse(text, "a text")
    assert time.process_time() - began < 1.0


def test_flags_and_variables_are_read_by_the_same_loader(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("INCSVR_STATE", "null")
    monkeypatch.setenv("INCSVR_VEHICLE__INERTIA", "0350")
    assert (read().state, read().vehicle.inertia) == (None, 350.0)
    monkeypatch.setenv("INCSVR_LEARNER", '{"gamma": 1, "gamma": 2}')
    with pytest.raises(BadInput, match="gamma is given here and in line 1"):
        read()


def test_a_learner_lists_no_others() -> None:
    with pytest.raises(BadInput, match="list all of them in one section"):
        read(None, {"learners": {"b": {"learners": {"c": {}}}}})
