"""What the tests of durable state share."""

from __future__ import annotations

import pytest

from service.learner.prepared_iteration import CommittedIteration
from tests.service.state import iterations


@pytest.fixture
def outcomes() -> list[CommittedIteration]:
    """Three iterations of a learner, made once."""
    return iterations.outcomes()
