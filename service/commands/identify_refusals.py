"""The refusals of a whole vehicle: a sensor that stood still, a model that runs away. No file is written then."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.errors import BadInput
from incsvr.plant.axes import AXES, YAW, Axis
from incsvr.vehicle import Vehicle, WholeMotion
from incsvr.vehicle.simulation import RUNAWAY
from service.commands.trace_sensors import examine_sensors, with_heading_sign
from service.recordings.recording import Recording, of_axis


def refuse_stuck(runs: Sequence[Recording], vehicle: Vehicle) -> None:
    """Refuses dives in which a velocity stood still under a changing effort, by the checks of `incsvr trace`.

    Raises:
        BadInput: naming the dive, the velocity and the time.
    """
    for axis in (AXES[name] for name in vehicle.driven):
        seen = [each for each in (_along(run, axis) for run in runs) if each is not None]
        inertia = vehicle.mass[axis.name, axis.name].value
        with_heading_sign(seen, examine_sensors(seen, inertia, sign_known=True))


def refuse_runaway(motion: WholeMotion, vehicle: Vehicle) -> None:
    """Refuses a model whose free run over its own dives leaves all that they recorded.

    Raises:
        BadInput: naming the axes, and what to record.
    """
    reached = np.abs(vehicle.free_run(motion)).max(axis=0)
    away = [name for k, name in enumerate(AXES) if name in vehicle.axes and _passed(reached[k], vehicle.fastest[k])]
    if away:
        raise BadInput(
            f"the model runs away: simulated over its own dives, it passes {RUNAWAY:g} times the fastest recorded "
            f"velocity of {' and '.join(away)}; nothing is written: record steps of the effort to both sides, each "
            "held until the speed settles"
        )


def _passed(reached: float, fastest: float) -> bool:
    return reached >= 0.999 * RUNAWAY * fastest  # where the simulation is clipped


def _along(run: Recording, axis: Axis) -> Recording | None:
    """A dive as a recording of one axis; None where it lacks its velocity or effort."""
    streams = run.body_streams()
    if any(name not in streams or not streams[name][0].size for name in (axis.rate, axis.effort)):
        return None
    return run if run.axis == axis else of_axis(run, axis) if run.axis == YAW else None
