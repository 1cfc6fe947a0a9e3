"""The torques that are subtracted from a learner's samples: those of its declared body and of traced effects."""

from __future__ import annotations

from typing import TYPE_CHECKING

from incsvr.signals.coupled import BodyTorque
from incsvr.signals.settings import SignalSettings
from incsvr.signals.torque_takers import TakesTorque

if TYPE_CHECKING:
    from incsvr.compensation.effects_in_force import Compensation
    from incsvr.plant.body import Coupled


def takes_torque(
    settings: SignalSettings, compensation: Compensation | None = None, coupled: Coupled | None = None
) -> TakesTorque | None:
    """The torques to subtract, for `Synchroniser` and `synchronise`; None if there are none.

    Args:
        settings: how streams become samples.
        compensation: the traced effects in force.
        coupled: the axis in a body whose mass matrix is declared; None takes it by itself.
    """
    body = None if coupled is None else BodyTorque(coupled, settings.inertia)
    if compensation is None:
        return body
    # Loaded where it is needed alone: it brings the catalogue of effects with it.
    from incsvr.compensation.torque_ledger import TorqueLedger

    return TorqueLedger(compensation, settings, body)
