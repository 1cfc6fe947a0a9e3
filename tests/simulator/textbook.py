"""The moment of each effect as a textbook has it, with the parameters that a simulated world tells of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from incsvr.numerics import Array

Parameters = Mapping[str, float | str]


@dataclass(frozen=True)
class Ride:
    """What truly happened to a vehicle, step by step, and what it was declared to be.

    Attributes:
        step: [s].
        command: (n,) the torque that was asked for [N m].
        rate, heading, acceleration: (n,) [rad/s], [rad], [rad/s²].
        drag: (n,) d(r) of the declared vehicle [N m].
        inertia: as declared [kg m²].
        channel: (n,) what the effect follows; empty for none.
        creep: the rate within which dry friction changes its side [rad/s].
    """

    step: float
    command: Array
    rate: Array
    heading: Array
    acceleration: Array
    drag: Array
    inertia: float
    channel: Array
    creep: float = 1e-9

    @property
    def time(self) -> Array:
        """(n,) since the start [s]."""
        return np.asarray(self.step * np.arange(self.rate.size, dtype=np.float64))

    def lacking(self, outside: Array | float = 0.0) -> Array:
        """(n,) the moment that inertia, drag, command and what acts from outside leave over [N m]."""
        return np.asarray(self.inertia * self.acceleration + self.drag - self.command - outside)


def moment(name: str, told: Parameters, ride: Ride) -> Array:
    """(n,) what the effect adds to I ṙ = τ − d(r) [N m]."""
    p = {key: float(value) for key, value in told.items() if not isinstance(value, str)}
    u, r, time, drag = ride.command, ride.rate, ride.time, ride.drag
    shape, kind = str(told.get("shape", "")), name.partition(":")[0]
    half, limit = p.get("half_width_nm", 0.0), p.get("limit_nm", 1.0)

    def after(rise: Array, seconds: float) -> Array:
        kept = np.exp(-ride.step / seconds)
        return np.asarray(lfilter([0.5 - 0.5 * kept] * 2, [1.0, -kept], rise))

    def lagging() -> Array:
        rotor = np.sign(u) * np.sqrt(np.abs(u)) if shape == "rotor speed" else u
        follows = after(rotor, p["time_constant_s"])
        return (follows * np.abs(follows) if shape == "rotor speed" else follows) - u

    def swallowed() -> Array:
        gate = shape in ("jump", "stiction")  # beyond the band a gear lacks the band, a rotor that sticks lacks nothing
        return np.where(np.abs(u) <= half, -u, 0.0) if gate else -np.clip(u, -half, half)

    def short() -> Array:
        if shape == "bend":
            return np.asarray(u / (1.0 + (u / limit) ** 4) ** 0.25 - u)
        return (limit * np.tanh(u / limit) if "sharpness" in shape else np.clip(u, -limit, limit)) - u

    moments: dict[str, Callable[[], Array]] = {
        "bias_torque": lambda: np.full(r.size, p["moment_nm"]),
        "inertia": lambda: (ride.inertia - p["inertia_kg_m2"]) * ride.acceleration,
        "torque_lag": lagging,
        "torque_delay": lambda: np.interp(time - p["delay_s"], time, u) - u,
        "dead_zone": swallowed,
        "torque_asymmetry": lambda: (p["reverse_efficiency"] - 1.0) * np.minimum(u, 0.0),
        "torque_saturation": short,
        "inflow": lambda: -p["coefficient"] * r * np.sqrt(np.abs(u)),
        "heading_current": lambda: p["amplitude_nm"] * np.sin(p["harmonic"] * ride.heading + p["phase_rad"]),
        "tether": lambda: -p["stiffness_nm_per_rad"] * (ride.heading - ride.heading[0]),
        "wave": lambda: p["amplitude_nm"] * np.sin(2 * np.pi * time / p["period_s"] + p["phase_rad"]),
        "drag_drift": lambda: -p["fraction"] * time / time[-1] * drag,
        "drag_step": lambda: -p["fraction"] * (time >= p["at_s"]) * drag,
        "memory": lambda: p["gain_nm_s"] * after(r, p["time_constant_s"]),
        "coulomb": lambda: -p["moment_nm"] * np.tanh(r / ride.creep),
        "bias_drift": lambda: p["nm_per_s"] * time,
        "coupling": lambda: p["coefficient"] * (ride.channel - p["origin"]),
        "modulation": lambda: (
            p["coefficient"] * (ride.channel - p.get("reference", p.get("origin", 0.0)))
            * (u if shape == "thrust" else -drag)
        ),
    }  # fmt: skip
    return moments[kind]()
