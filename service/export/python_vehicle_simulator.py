"""A module for Fossen's PythonVehicleSimulator, whose vehicles are classes with matrices M and D and with constants.

Its vehicles count D = −diag(X_u, …, N_r), positive where damping opposes, and each adds what is quadratic in its own
`dynamics`. It works in NED: both coefficients are the same there, for d(−r) = −d(r); a constant moment changes sign.
"""

from __future__ import annotations

from service.export.damping_model import DampingModel, Value

_BODY = '''\
import numpy as np

N_R = {linear!r}  # N m s/rad
N_R_ABS_R = {quadratic!r}  # N m s^2/rad^2
IZZ = {inertia!r}  # kg m^2, body and water together
TRAINED_RATES = ({low!r}, {high!r})  # rad/s; beyond, a guess
THRUST_TIME_CONSTANT = {lag}  # s; T_n of a vehicle, None where no lag was traced
THRUST_DELAY = {delay}  # s
REVERSE_EFFICIENCY = {reverse}  # of reverse thrust over forward
DEAD_BAND = {band}  # N m of the commanded moment to each side that give nothing
CONSTANT_MOMENT = {bias}  # N m, positive as the yaw rate of the recordings


def put_into(vehicle):
    """Gives a vehicle of PythonVehicleSimulator this inertia and this linear damping about yaw."""
    vehicle.M[5, 5] = IZZ
    vehicle.Minv = np.linalg.inv(vehicle.M)
    vehicle.D[5, 5] = -N_R
    if THRUST_TIME_CONSTANT is not None and hasattr(vehicle, "T_n"):
        vehicle.T_n = THRUST_TIME_CONSTANT


def quadratic_yaw_damping(r):
    """The moment N_r|r| r|r| [N m]: in the vehicle's dynamics() it stands where tau_damp[5] is changed."""
    return N_R_ABS_R * abs(r) * r
'''


def module(model: DampingModel) -> str:
    """The text of the module."""
    low, high = model.valid
    head = '"""By incsvr export.\n\n' + "\n".join(model.remark()).replace("\\", "/") + '\n"""\n\n'
    return head + _BODY.format(
        linear=-model.linear.estimate,
        quadratic=-model.quadratic.estimate,
        inertia=model.inertia.estimate,
        low=low,
        high=high,
        lag=_or_none(model.of("torque_lag", "time_constant_s")),
        delay=_or_none(model.of("torque_delay", "delay_s")),
        reverse=_or_none(model.of("torque_asymmetry", "reverse_efficiency")),
        band=_or_none(model.of("dead_zone", "half_width_nm")),
        bias=_or_none(model.of("bias_torque", "moment_nm")),
    )


def _or_none(value: Value | None) -> str:
    return "None" if value is None else repr(value.estimate)
