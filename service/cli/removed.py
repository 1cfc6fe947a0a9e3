"""Commands, flags, and values of flags, that left: each is refused with one sentence that names what to do instead."""

from __future__ import annotations

from collections.abc import Mapping

LOG = "`incsvr inspect LOG --plot FILE` draws a log"
REMOVED: Mapping[tuple[str, str], str] = {
    ("demo", "--vehicle"): "name the vehicle of --log with --log-of",
    ("view", "--repair"): "a recording that was cut off opens as it is",
    ("page", "--archive"): "the files of `incsvr serve --archive DIR` are in DIR",
    ("page", "--identify"): "use `incsvr identify LOG --report FILE.html`",
    **{("view", flag): LOG for flag in ("--inertia", "--preset", "--column", "--system", "--axis", "--from", "--to")},
    ("keys", "--router"): "make the keys of each vehicle at its own listener, or write the access control of a shared "
    "router by Zenoh's documentation",
    ("compare", "--from-learner"): "compare the logs of the dives (`serve --archive` records them), or stored tables "
    "of dives",
    ("trace", "--manoeuvre"): "`next_manoeuvre` says what a log must show; write the efforts of a drive yourself, as a "
    "CSV file with the columns t and torque, and `incsvr simulate --torque FILE.csv` plays it",
    **{(name, "--torque"): "give --set signals.torque=commanded or measured" for name in ("fit", "trace")},
    **{
        (name, "--mass-matrix"): "give --set vehicle.mass_matrix=M, or --vehicle FILE of `incsvr identify --write`"
        for name in ("fit", "trace", "identify")
    },
    ("compare", "--mass-matrix"): "give --set vehicle.mass_matrix=M",
    ("fit", "--smoothing"): "give --set signals.smoothing=S",
    ("fit", "--inputs"): "give --set learner.inputs=NAMES",
    ("incsvr", "inputs"): "use `incsvr inspect --bus`, with the same flags",
    ("tune", "--simulated"): "`incsvr table1` searches on the simulated Leng",
    ("tune", "--last"): "the column last step has this error",
    ("export", "--link"): "replace base_link in the exported file",
    ("export", "--format uuv"): "take gazebo for gz-sim, or json and put its figures into a <hydrodynamic_model>",
    ("export", "--format python-vehicle-simulator"): "take python, and call its acceleration in the dynamics of your "
    "vehicle",
}
"""By command, and flag or flag and value; by the program, and command."""
