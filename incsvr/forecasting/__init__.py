"""The model as a stand-in for the gyro: yaw rate and heading from the torque alone, with an interval that holds."""

from __future__ import annotations

from incsvr.forecasting.experience import Experience
from incsvr.forecasting.forecast import Forecast, Start, Surroundings, forecast
from incsvr.forecasting.grid import Grid

__all__ = ["Experience", "Forecast", "Grid", "Start", "Surroundings", "forecast"]
