"""What health says of the process beside the learner: how often it died, and how long it takes."""

from __future__ import annotations

from service.live.tracing_process import DEADLINE_S
from service.live.worker_watch import LONG_WORK_S, WorkerWatch


def test_deaths_are_counted_until_there_is_an_answer() -> None:
    watch = WorkerWatch()
    assert watch.notices() == ()
    for often in ("once", "2 times one after the other", "3 times one after the other"):
        watch.begin("trace")
        watch.fail("trace", "its process was killed by signal 9")
        (said,) = watch.notices()
        assert said.startswith(f"the tracing process gave no result: its process was killed by signal 9 ({often});")
    watch.begin("prove")
    watch.end()
    assert watch.notices() == ()


def test_work_that_takes_minutes_is_told_while_it_takes_them() -> None:
    now = 10.0
    watch = WorkerWatch(lambda: now)
    watch.begin("prove")
    now += LONG_WORK_S
    assert watch.notices() == ()
    now += 1.0
    (said,) = watch.notices()
    assert said.startswith(
        f"the proof in the tracing process has run for 121 s and is stopped after {DEADLINE_S:.0f} s;"
    )
    watch.fail("prove", "it was stopped after 600 s")
    (said,) = watch.notices()
    assert "gave no result: it was stopped after 600 s (once)" in said
