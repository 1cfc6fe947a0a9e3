"""Learners of one prefix that start in the same moment: one stays, whichever it is, and the others say so."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest
import zenoh

from incsvr.errors import BadInput
from service.bus.session import client_config_at, free_endpoint, open_session, take_prefix

LEARNERS = 3


def router(endpoint: str) -> zenoh.Config:
    config = zenoh.Config.from_json5('{mode: "router", scouting: {multicast: {enabled: false}}}')
    config.insert_json5("listen/endpoints", f'["{endpoint}"]')
    return config


@pytest.mark.slow
def test_of_several_that_start_in_the_same_moment_exactly_one_stays() -> None:
    endpoint, together = free_endpoint(), threading.Barrier(LEARNERS)

    def come(session: zenoh.Session) -> object:
        together.wait()
        try:
            return take_prefix(session, "leng/yaw", threading.Event(), hub=True)
        except BadInput as refusal:
            return str(refusal)

    with open_session(router(endpoint)):
        sessions = [open_session(client_config_at(endpoint)) for _ in range(LEARNERS)]
        try:
            with ThreadPoolExecutor(LEARNERS) as threads:
                outcomes = list(threads.map(come, sessions))
            refused = [outcome for outcome in outcomes if isinstance(outcome, str)]
            assert len(refused) == LEARNERS - 1
            assert all("another learner has the prefix leng/yaw" in sentence for sentence in refused)
        finally:
            for session in sessions:
                session.close()  # type: ignore[no-untyped-call]
