"""A pause that takes back all that was learned: the empty model before everybody who reads one."""

from __future__ import annotations

import json
import re

import pytest
import zenoh

from service.cli.command_line import main
from service.wire import DampingReply, ErrorReply, ModelSnapshot, decode
from tests.viewer.conftest import KEYS, PATIENCE, House, Run, learn_until, publish
from tests.viewer.readback import rows
from tests.viewer.test_page import fetched


def asked(session: zenoh.Session, selector: str) -> bytes:
    """The answer to a question, be it an error."""
    (reply,) = list(session.get(selector, timeout=PATIENCE))
    if reply.ok is not None:
        return reply.ok.payload.to_bytes()
    assert reply.err is not None
    return reply.err.payload.to_bytes()


def read_by_all(house: House, session: zenoh.Session, capsys: pytest.CaptureFixture[str]) -> None:
    """The answers of the bus, of every command and of the page, with the second revision in force."""
    model = json.loads(asked(session, KEYS.model))
    assert (model["revision"], model["iteration"]) == (2, 2)
    assert not any(model["support"].values())
    assert [model[name] for name in ("sigma", "trained_range", "certified_error")] == [None] * 3
    damping = f"{KEYS.damping}?rate=0.1"
    for selector in (damping, f"{damping};revision=2", f"{damping};at={model['t']!r}"):
        refusal = decode(ErrorReply, asked(session, selector))
        assert (refusal.error_type, "learned" in refusal.error) == ("NothingLearned", True)
    assert decode(ErrorReply, asked(session, KEYS.forecast)).error_type == "NothingLearned"
    assert decode(ErrorReply, asked(session, f"{KEYS.model}?revision=3")).error
    first = decode(ModelSnapshot, asked(session, f"{KEYS.model}?revision=1"))
    assert len(first.support)
    assert decode(DampingReply, asked(session, f"{damping};revision=1")).revision == 1
    capsys.readouterr()
    where = ("--connect", house.endpoint, "--wait", "1")
    for words, status in (
        (["query", "0.1", *where], 1),
        (["status", *where], 1),
        (["export", *where], 2),
        (["export", str(house.folder / "state")], 2),
    ):
        assert main(words) == status, words
        said = "".join(capsys.readouterr())
        assert "Traceback" not in said
        assert "0 vectors" in said if words[0] == "status" else re.search("nothing (was|has been) learned", said)
    page = house.start(["page", "--connect", house.endpoint, "--port", "0"])
    url = re.findall(r"http://\S+", page.wait_for("shows leng/yaw"))[0]
    shown = json.loads(fetched(f"{url}state.json"))
    assert (shown["away"], shown["model"], shown["health"]["revision"]) == (None, None, 2)
    page.end()


@pytest.mark.slow
def test_a_model_that_was_taken_back_whole_is_published_empty_and_read_by_all(
    house: House, run: Run, capsys: pytest.CaptureFixture[str]
) -> None:
    first, second = (report.t + 1.5 for report, _ in run.iterations[:2])
    reversed_ = {
        name: (t, -value if name == "torque" else value) for name, (t, value) in run.part(first, second).items()
    }
    learner = house.serve()
    session = house.client()
    path = house.folder / "run.rrd"
    viewer = house.view("--headless", "--save", str(path))
    viewer.wait_for("the learner is here")
    learn_until(session, 1, lambda: publish(session, run.part(0.0, first)))
    learn_until(session, 2, lambda: publish(session, reversed_))
    viewer.wait_for("iteration 2 ")
    assert viewer.end() == 0
    assert set(rows(path, "LineStrips2D:strips")["/learning/function"]) >= {1}
    read_by_all(house, session, capsys)
    assert learner.end() == 0
    assert not any("fault of this program" in line or "Traceback" in line for line in learner.said)
    house.serve()
    session = house.client()  # the first client comes back in its own time
    read_by_all(house, session, capsys)
    learn_until(session, 4, lambda: publish(session, run.part(second, run.iterations[5][0].t + 1.5)))
    assert len(decode(ModelSnapshot, asked(session, KEYS.model)).support)
