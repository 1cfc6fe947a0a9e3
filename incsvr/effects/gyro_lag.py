"""A filter on the gyro: an alternative of the rotor's lag that the streams hardly tell from it."""

from __future__ import annotations

from incsvr.effects.torque_lag import TorqueLag


class GyroLag(TorqueLag):
    """T r_m′ + r_m = r. To first order I (r + T ṙ)′ + d(r + T ṙ) = τ, as with a lag of the thrust.

    Both show the answer later than the command; only how the vehicle answers the water tells them apart. Never named on
    its own: it stands among the alternatives, so that its tie is computed.
    """

    name = "gyro_lag"
    sentence = "the gyro is filtered with the time constant T"
    source = "L. Ljung, System Identification, 1999, ch. 13 (sensors in the loop)"

    def __init__(self) -> None:
        super().__init__("moment")
        self.variant = ""
