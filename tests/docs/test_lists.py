"""The generated lists of the reference are what the program generates now."""

from __future__ import annotations

import pytest

from tests.conftest import ROOT
from tests.docs.lists import LISTS, generated


@pytest.mark.parametrize("name", LISTS)
def test_a_page_lists_what_the_program_has(name: str) -> None:
    text = (ROOT / name).read_text(encoding="utf-8")
    assert text == generated(name, text), "`python -m tests.docs.regenerate` writes it anew"
