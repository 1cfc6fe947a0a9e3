"""The vehicle's controller: at every beat it reads its sensors and says a torque, which is held until the next beat."""

from __future__ import annotations

from simulator.missions.plans import Plan

NEAR = 0.3
"""The integral of a heading control stands still while the heading is off by more [rad]: it is for what lasts."""
SETTLED = 0.2
"""A correction out of the dead band ends when so much of the band is left."""


class Autopilot:
    """A plan's law with its memory: the integral, and whether a correction out of the dead band is going on.

    Args:
        plan: what is asked for.
        limit: the largest torque that may be commanded [N m].
        period: of the beats [s].
    """

    def __init__(self, plan: Plan, limit: float, period: float) -> None:
        self._plan, self._limit, self._period = plan, limit, period
        self._integral = 0.0
        self._correcting = plan.dead_band == 0.0

    def command(self, beat: int, rate: float, heading: float) -> float:
        """The torque [N m] for the gyro's rate [rad/s] and the compass's heading [rad], counted on."""
        plan = self._plan
        wish = plan.wish[beat]
        if plan.law == "torque":
            return wish
        error = wish - (heading if plan.law == "heading" else rate)
        if plan.dead_band:
            threshold = plan.dead_band * (SETTLED if self._correcting else 1.0)
            self._correcting = abs(error) > threshold
            if not self._correcting:
                return 0.0
        asked = plan.proportional * error - plan.derivative * rate + self._integral
        if plan.ahead:
            asked += plan.ahead[beat]
        limited = min(max(asked, -self._limit), self._limit)
        if asked == limited and (plan.law == "rate" or abs(error) < NEAR):
            self._integral += plan.integral * error * self._period
        return limited
