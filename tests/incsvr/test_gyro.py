"""Gyros that are clipped are refused; those that are coarse, at rest or held between samples are not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.tracing.gyro import check_gyro
from service.recordings.reading import read
from tests.worlds import trial


def streams(excitation: str = "multisine", vehicle: str = "leng") -> tuple[Array, Array, Array]:
    columns = trial(3, (), vehicle, excitation, 150.0).recording
    turned, pushed = np.isfinite(columns.columns["yaw_rate"]), np.isfinite(columns.columns["torque"])
    time = columns.time[turned]
    torque = np.interp(time, columns.time[pushed], columns.columns["torque"][pushed])
    return time, columns.columns["yaw_rate"][turned], np.asarray(torque, dtype=np.float64)


def coarse(rate: Array, step: float) -> Array:
    return np.asarray(step * np.round(rate / step), dtype=np.float64)


@pytest.mark.parametrize("sides", [(-0.6, 0.6), (-9.0, 0.6), (-0.6, 9.0)])
def test_a_clipped_gyro_is_named_with_its_limit(sides: tuple[float, float]) -> None:
    time, rate, torque = streams()
    most = float(np.max(np.abs(rate)))
    limits = [side * most for side in sides]
    limit = max((x for x in limits if abs(x) < most), default=0.0)
    with pytest.raises(BadInput, match=f"clipped at {limit:.4g} rad/s, .* wider range"):
        check_gyro("run", time, np.asarray(np.clip(rate, limits[0], limits[1]), dtype=np.float64), torque)


@pytest.mark.parametrize(("excitation", "vehicle"), [("multisine", "leng"), ("steps", "small"), ("telegraph", "small")])
def test_a_coarse_gyro_is_no_broken_one(excitation: str, vehicle: str) -> None:
    time, rate, torque = streams(excitation, vehicle)
    check_gyro("run", time, rate, torque)
    for step in (1e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1):
        check_gyro("run", time, coarse(rate, step), torque)


def test_a_vehicle_at_rest_and_a_stream_held_between_samples_are_sound() -> None:
    time, rate, torque = streams()
    waiting = time < 50.0
    check_gyro("run", time, np.where(waiting, 0.0, rate), np.where(waiting, 0.0, torque))
    held = rate[np.arange(rate.size) // 20 * 20]
    check_gyro("run", time, held, torque)


def test_the_measured_gyro_is_sound(measured: Path) -> None:
    for path in sorted((measured / "bluerov").glob("run_*.csv")):
        run = read(path)
        streams = run.streams()
        time, rate = streams["yaw_rate"]
        check_gyro(run.name, time, rate, np.asarray(np.interp(time, *streams["torque"]), dtype=np.float64))
