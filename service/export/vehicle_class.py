"""A whole vehicle as a class of Fossen's PythonVehicleSimulator, whose `simulate` calls `stepInput` and `dynamics`.

Its loop (lib/mainLoop.py) integrates ν by `dynamics` and η by Euler's method. The class holds every term of the model.
"""

from __future__ import annotations

from incsvr.vehicle import Vehicle
from service.export.whole_vehicle import python_module

_CLASS = '''

class Vehicle:
    """The vehicle for PythonVehicleSimulator: `simulate(N, sampleTime, Vehicle(lambda t: [20, 0, 0, 0, 0, 1]))`."""

    def __init__(self, effort=lambda t: np.zeros(6)):
        """effort(t) gives the forces [N] and moments [N m], surge to yaw, at t [s]."""
        self.name = {name!r}
        self.L = None  # length [m], which is printed alone
        self.controlMode, self.controlDescription = "stepInput", "forces and moments over time"
        self.controls = [f"{{axis}} effort" for axis in AXES]
        self.dimU = 6
        self.nu, self.u_actual = np.zeros(6), np.zeros(6)
        self.effort = effort

    def stepInput(self, t):
        """The commands at t [s]."""
        return np.array(self.effort(t), dtype=float)

    def dynamics(self, eta, nu, u_actual, u_control, sampleTime):
        """nu and the efforts behind the thrusters' lag, one step of Euler's method later."""
        u_actual = np.array(u_control, dtype=float) + _lag(sampleTime) * (u_actual - u_control)
        return nu + sampleTime * acceleration(nu, u_actual, eta[3:5]), u_actual


def _lag(dt):
    """What is left of the way to each command after dt [s]."""
    left = np.zeros(6)
    for place, constant in THRUST_LAG_S.items():
        left[place] = np.exp(-dt / max(constant, 1e-9))
    return left
'''


def class_module(vehicle: Vehicle) -> str:
    """The file's text: the Python module of the vehicle, and the class beside its functions."""
    return python_module(vehicle) + _CLASS.format(name=vehicle.name)
