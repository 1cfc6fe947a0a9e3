"""What all tests share."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def measured() -> Path:
    """The folder of measured recordings beside the checkout; they carry no licence and are never copied here."""
    folder = ROOT.parent / "shared" / "measured"
    if not folder.is_dir():
        pytest.skip("the measured recordings are not beside this checkout (../shared/measured)")
    return folder
