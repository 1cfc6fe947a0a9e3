"""Names that left the configuration, each with what takes its place."""

from __future__ import annotations

REMOVED = {
    "vehicle.file": "`incsvr serve --vehicle FILE` learns its axes, as does a copy of its section learners",
    "also": "list every learner of the process in the section learners, each under a name",
    "inputs.thrusters.also_along": "the thrusters' positions give the efforts of all axes of `learners`",
    "learner.bins": "the criterion has 20 bins",
    "learner.near": "over several velocities the policy weighted learns, which needs none",
    "bus.allow_second": "give the second learner another prefix",
    "health.stuck_after": "a yaw rate that is constant for 2 s is a fault",
    "health.warn_for": "health shows a rejected sample for 10 s",
    "health.fresh_for": "a sample counts as fresh for 900 s",
    "health.diagnostics": "a node of ROS 2 asks the key PREFIX/health, which is JSON",
    "archive.file_mb": "a file ends at 32 MB; archive.most_mb limits all files together",
    "simulation": "`incsvr simulate` has the flags --runs, --seed, --underway, --drop-outs, --jitter and --duplicates",
}


def unknown(name: str) -> str:
    """The sentence that refuses a name which is not, or no longer, in the configuration."""
    instead = REMOVED.get(name)
    if instead is None:
        return f"there is no {name}; `incsvr config show` lists all names"
    return f"{name} left the configuration; leave it out: {instead}"
