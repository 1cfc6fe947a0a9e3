"""Flags that left: each is refused with one sentence that names what to do instead."""

from __future__ import annotations

from collections.abc import Mapping

LOG = "`incsvr inspect LOG --plot FILE` draws a log"
REMOVED: Mapping[tuple[str, str], str] = {
    ("view", "--repair"): "a recording that was cut off opens as it is",
    ("page", "--archive"): "the files of `incsvr serve --archive DIR` are in DIR",
    ("page", "--identify"): "use `incsvr identify LOG --report FILE.html`",
    **{("view", flag): LOG for flag in ("--inertia", "--preset", "--column", "--system", "--axis", "--from", "--to")},
}
"""By command and flag."""
