"""What the command line no longer takes, each with a sentence that names what to do instead."""

from __future__ import annotations

REMOVED = {
    "incsvr keys --router": "--router was removed; make the keys of each vehicle at its own listener, or write the "
    "access control of a shared router by Zenoh's documentation",
    "incsvr compare --from-learner": "--from-learner was removed; compare the logs of the dives (`serve --archive` "
    "records them), or stored tables of dives",
    "incsvr export --link": "--link was removed; replace base_link in the exported file",
    "incsvr export --format uuv": "--format uuv was removed; take gazebo for gz-sim, or json and put its figures into "
    "a <hydrodynamic_model>",
    "incsvr export --format python-vehicle-simulator": "--format python-vehicle-simulator was removed; take python, "
    "and call its acceleration in the dynamics of your vehicle",
}
"""Command and flag, or command, flag and value → the sentence."""
