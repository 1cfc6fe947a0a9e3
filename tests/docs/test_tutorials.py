"""Every command of the tutorials runs, in order, in an empty directory, and prints what the page shows."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.docs.console import BLOCK, PAGES, commands, differs, printed


@pytest.mark.slow
@pytest.mark.parametrize("name", PAGES)
def test_a_page_shows_what_the_program_prints(name: str, tmp_path: Path) -> None:
    page = ROOT / name
    found = differs(page.read_text(encoding="utf-8"), printed(page, tmp_path))
    assert found is None, f"{name}: {found}\n`python -m tests.docs.regenerate` writes it anew"


@pytest.mark.parametrize("name", PAGES)
def test_a_page_runs_something(name: str) -> None:
    blocks = BLOCK.findall((ROOT / name).read_text(encoding="utf-8"))
    assert any(kind == "python" or list(commands(body)) for kind, body, _ in blocks)


def test_another_figure_or_word_is_noticed() -> None:
    assert differs("MAE 3.97 N m", "MAE 3.98  N m") is None
    assert differs("played 300 s, 90 messages, in 6 s", "played 300 s, 90 messages, in 9 s") is None
    assert "the page says 3.97, the program 4.97" in str(differs("MAE 3.97 N m", "MAE 4.97 N m"))
    assert "the program says" in str(differs("the model lacks inertia", "the model lacks nothing"))
    assert "printed" in str(differs("one\n", "one\ntwo\n"))


def test_a_command_that_fails_is_noticed(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("```console\n$ incsvr fit no_such.csv --inertia 1\n```\n", encoding="utf-8")
    with pytest.raises(AssertionError, match="no such file"):
        printed(page, tmp_path)
