"""A state that is damaged between two starts."""

from __future__ import annotations

import shutil
import sqlite3
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.service.bus import KEYS
from benchmarks.service.hold.row import Row
from benchmarks.service.hold.subject import Subject, fed, same
from service.wire import ModelSnapshot

Damage = Callable[[Path, np.random.Generator], None]


def a_flipped_bit(path: Path, random: np.random.Generator) -> None:
    content = bytearray(path.read_bytes())
    content[random.integers(len(content))] ^= 1 << random.integers(8)
    path.write_bytes(content)


def a_sector_of_zeros(path: Path, random: np.random.Generator) -> None:
    content = bytearray(path.read_bytes())
    first = 512 * random.integers(len(content) // 512)
    content[first : first + 512] = bytes(512)
    path.write_bytes(content)


def cut_short(path: Path, random: np.random.Generator) -> None:
    content = path.read_bytes()
    path.write_bytes(content[: random.integers(len(content))])


def without_bytes(path: Path, random: np.random.Generator) -> None:
    path.write_bytes(b"")


def removed(path: Path, random: np.random.Generator) -> None:
    path.unlink()


def a_directory_instead(path: Path, random: np.random.Generator) -> None:
    path.unlink()
    path.mkdir()


def another_row(path: Path, random: np.random.Generator) -> None:
    statements = (
        "UPDATE memory SET value = '{}'",
        "UPDATE memory SET value = replace(CAST(value AS TEXT), '1', '2')",
        "UPDATE identity SET value = '[2, 2]' WHERE name = 'form'",
        "UPDATE history SET snapshot = (SELECT snapshot FROM history WHERE revision = 1)",
        "DELETE FROM history WHERE revision = (SELECT max(revision) FROM history)",
        "ALTER TABLE memory ADD COLUMN more",
    )
    with sqlite3.connect(path) as connection:
        connection.execute(statements[random.integers(len(statements))])
    connection.close()


def a_foreign_journal(path: Path, random: np.random.Generator) -> None:
    for end in ("-journal", "-wal"):
        path.with_name(path.name + end).write_bytes(random.bytes(5000))


KINDS: tuple[tuple[Damage, float], ...] = (
    (a_flipped_bit, 0.5),
    (a_sector_of_zeros, 0.15),
    (cut_short, 0.1),
    (another_row, 0.1),
    (a_foreign_journal, 0.05),
    (without_bytes, 0.04),
    (removed, 0.03),
    (a_directory_instead, 0.03),
)
"""With the part of the tries that each has."""


def damages(times: int, seed: int) -> list[Row]:
    """Damages copies of one state, and asks a learner that starts on each for the model and for all revisions."""
    random = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as scratch:
        whole, state = Path(scratch, "whole"), Path(scratch, "state")
        with Subject(whole) as subject, fed(subject.endpoint):
            subject.wait_for(12)
            subject.kill()
            published = dict(subject.published)
        rows = []
        for damage, part in KINDS:
            tried = max(round(part * times), 1)
            found = [_tried(damage, random, whole, state, published) for _ in range(tried)]
            rows.append(
                Row(
                    f"the state: {damage.__name__.replace('_', ' ')}",
                    tried,
                    sum(lost for lost, _, _ in found),
                    sum(wrong for _, wrong, _ in found),
                    [until for lost, _, until in found if lost],
                    f"of {tried * (1 + len(published))} models, latest and earlier; time until health says it",
                )
            )
    return rows


def _tried(
    damage: Damage, random: np.random.Generator, whole: Path, state: Path, published: dict[int, ModelSnapshot]
) -> tuple[int, int, float]:
    """What is lost, what is wrong or lost without a word, and the time from the start until health has said it [s]."""
    shutil.rmtree(state, ignore_errors=True)
    shutil.copytree(whole, state)
    damage(state / f"{KEYS.prefix}.sqlite", random)
    began = time.monotonic()
    with Subject(state) as subject:
        subject.published = published
        newest = max(published)
        served = subject.ask(KEYS.model, ModelSnapshot)
        lost = int(served is None)
        wrong = int(served is not None and not (served.revision >= newest and _agrees(served, published)))
        missing, otherwise = subject.wrong_answers(sorted(published))
        lost, wrong = lost + missing, wrong + otherwise
        said = " ".join(subject.health().reasons)
        until = time.monotonic() - began
        # What was said after the first answers comes with health's next second.
        while lost and "state" not in said and "history" not in said and time.monotonic() - began < 10.0:
            said = " ".join(subject.health().reasons)
            until = time.monotonic() - began
        wrong += int(bool(lost) and "state" not in said and "history" not in said)
    return lost, wrong, until


def _agrees(model: ModelSnapshot, published: dict[int, ModelSnapshot]) -> bool:
    return model.revision not in published or same(model, published[model.revision])
