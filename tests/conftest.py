"""What all tests share."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def measured() -> Path:
    """The folder of measured recordings beside the checkout; they carry no licence and are never copied here."""
    folder = ROOT.parent / "shared" / "measured"
    if not folder.is_dir():
        pytest.skip("the measured recordings are not beside this checkout (../shared/measured)")
    return folder


@pytest.fixture(scope="session")
def field_logs() -> Path:
    """The folder of real logs beside the checkout; they are never copied here."""
    folder = ROOT.parent / "shared" / "logs"
    if not folder.is_dir():
        pytest.skip("the real logs are not beside this checkout (../shared/logs)")
    return folder


@pytest.fixture(scope="session")
def trouble() -> Path:
    """The folder of troubles that people had in public, beside the checkout; they are never copied here."""
    folder = ROOT.parent / "shared" / "trouble"
    if not folder.is_dir():
        pytest.skip("the troubles of others are not beside this checkout (../shared/trouble)")
    return folder


# One set of examples for everybody: a failure that somebody sees, everybody sees.
settings.register_profile("ci", derandomize=True, deadline=None, print_blob=True)
settings.register_profile("explore", deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))
