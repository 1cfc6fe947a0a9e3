"""What the command line no longer takes, each with a sentence that names what to do instead."""

from __future__ import annotations

REMOVED = {
    "incsvr compare --from-learner": "--from-learner was removed; compare the logs of the dives (`serve --archive` "
    "records them), or stored tables of dives",
}
"""Command and flag, or command, flag and value → the sentence."""
