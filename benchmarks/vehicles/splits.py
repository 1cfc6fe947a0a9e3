"""Which recordings of the measured vehicles are fitted and which are judged on, stated before any figure was seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from incsvr.plant.axes import AXES


@dataclass(frozen=True, slots=True)
class Split:
    """What is fitted, and what it is judged on.

    Attributes:
        vehicle: folder of its recordings.
        axis: which of its motions.
        inertia: declared [kg m²].
        source: where that comes from.
        fitted, unseen: names of recordings.
        about: what a reader must know.
        mass_matrix: M of the whole body as `incsvr fit --mass-matrix` takes it, where it is known.
    """

    vehicle: str
    axis: str
    inertia: float
    source: str
    fitted: tuple[str, ...]
    unseen: tuple[str, ...]
    about: str = ""
    mass_matrix: str | None = None

    @property
    def name(self) -> str:
        return f"{self.vehicle}, {self.axis}: {', '.join(self.fitted)} → {', '.join(self.unseen)}"


def _runs(pattern: str, *numbers: str) -> tuple[str, ...]:
    return tuple(pattern.format(number) for number in numbers)


def _both_ways(vehicle: str, axis: str, inertia: float, source: str, first: Sequence[str], second: Sequence[str],
               about: str = "", mass_matrix: str | None = None) -> list[Split]:  # fmt: skip
    """One half to fit and the other to judge, and the other way round."""
    one, other = tuple(first), tuple(second)
    return [Split(vehicle, axis, inertia, source, *each, about, mass_matrix) for each in ((one, other), (other, one))]


_ROV = ("bluerov", "yaw", 1.125, "published")
_AUV = _runs("run_{}", "01", "03", "05", "07"), _runs("run_{}", "04")
_AUV_MASS = "2200,2500,0,0,0,0"
"""Not of yaw, whose torque stands in another unit than the forces."""
_BOAT = _runs("run_{}", "220", "221", "224", "225"), _runs("run_{}", "230", "233", "234")
_TANKER = _runs("Z_{}", "05_01", "10_10_P", "20_10_S", "35_05"), _runs("Z_{}", "10_05", "15_05", "25_05")
SPLITS = (
    Split(*_ROV, _runs("run_{}", "04", "05"), _runs("run_{}", "03"), "open loop"),
    Split(*_ROV, _runs("run_{}", "03", "04"), _runs("run_{}", "05"), "open loop"),
    Split(*_ROV, _runs("run_{}", "03", "05"), _runs("run_{}", "04"), "open loop"),
    Split(*_ROV, _runs("run_{}", "12", "13", "14", "15"), _runs("run_{}", "07", "08", "09", "10", "11"), "closed loop"),
    *_both_ways("dagon", "surge", 2200.0, "output error", *_AUV, mass_matrix=_AUV_MASS),
    *_both_ways("dagon", "sway", 2500.0, "output error", *_AUV, mass_matrix=_AUV_MASS),
    *_both_ways("dagon", "yaw", 800.0, "output error", *_AUV),
    *_both_ways("blueboat", "surge", 41.8, "published", *_BOAT),
    *_both_ways("blueboat", "yaw", 25.65, "published", *_BOAT),
    *_both_ways("blueboat", "yaw", 5.7, "the makers'", *_BOAT, "declared four times too small"),
    *_both_ways("kvlcc2", "yaw", 16100.0, "published", *_TANKER),
)  # fmt: skip


def skipped(folder: Path) -> list[dict[str, str]]:
    """The axes of every vehicle of which nothing can be asked, and why."""
    rows = []
    for vehicle in dict.fromkeys(split.vehicle for split in SPLITS):
        with min((folder / vehicle).glob("*.csv")).open(encoding="utf-8") as file:
            recorded = file.readline().strip().split(",")
        for axis in AXES.values():
            if any((split.vehicle, split.axis) == (vehicle, axis.name) for split in SPLITS):
                continue
            missing = " nor ".join(name for name in (axis.rate, axis.effort) if name not in recorded)
            rows.append({"vehicle": vehicle, "axis": axis.name, "why": f"no {missing} was recorded"})
    return rows
