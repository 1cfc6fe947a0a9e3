"""The texts of the demo: a line for each iteration, and Table I at the end, in at most 80 columns."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from incsvr.errors import Failed
from service.cli.output import WIDTH
from service.commands.demo_underway import summary as underway
from service.wire import IterationReport

HEAD = """\
iter: iteration, 50 samples each; t: the vehicle's time at its end. Samples: new
ones, discarded in the tube, discarded near a vector. Vectors: forgotten,
outliers, served. ms: training time. Mean absolute error [N m] of the served
model: on the batch before it is learned, on V1 (no hull), on V2 (hull).

iter   t s   new  tube  near forgot  outliers  vectors     ms  batch   V1   V2"""
_COUNTS = {"new": 5, "discarded_tube": 5, "discarded_near": 5, "forgotten": 7, "outliers": 9, "support": 8}
"""The counts of an iteration, and how wide their columns are."""


def line(report: IterationReport) -> str:
    """One iteration: its counts, training time, and errors on the batch, on V1 and on V2."""
    counts = " ".join(f"{report.counts[name]:{width}d}" for name, width in _COUNTS.items())
    error = {each.name: each.mae for each in report.validation}
    batch = "–" if report.progressive_mae is None else f"{report.progressive_mae:.1f}"
    said = (
        f"{report.iteration:4d} {report.t:5.0f} {counts} {report.training_ms:6.1f} {batch:>6s} "
        f"{error['V1']:4.1f} {error['V2']:4.1f}"
    )
    return said if report.change is None else "\n".join((said, *textwrap.wrap(f"     {report.change}", WIDTH)))


def played(history: Sequence[IterationReport], hull_comes: float) -> dict[str, Any]:
    """The result of the experiment on the bus, by the learner's iterations.

    Args:
        history: its iterations.
        hull_comes: the vehicle's time [s].
    """
    bare = [report for report in history if report.t <= hull_comes]
    parts = {"V1": bare, "V2": history[len(bare) :]}
    if not all(parts.values()):
        raise Failed("an experiment ended before its first iteration; see serve.log")
    served = []
    for name, part in parts.items():
        error = next(each for each in part[-1].validation if each.name == name)
        vectors = part[-1].counts["support"]
        served.append({"validation": name, "mae": error.mae, "rmse": error.rmse, "support_vectors": vectors})
    return {
        "iterations": len(history),
        "iterations_without_hull": len(bare),
        "served": served,
        "mae_per_iteration": {
            name: [next(each.mae for each in report.validation if each.name == name) for report in history]
            for name in parts
        },
        "vehicle_seconds": history[-1].t,
        "recording": None,
    }


def summary(result: Mapping[str, Any], out: Path) -> str:
    lines = ["", *_table(result["table1"])]
    lines += ["", *underway(result["underway"]), ""]
    refused = ", ".join(f"{count} {name.removeprefix('rejected:')}" for name, count in result["rejected"].items())
    lines.append(f"rejected: {refused or 'nothing'}")
    file = result["recording"]
    if file is None:
        lines.append("no recording: the viewer is not installed (pip install '.[viewer]')")
    else:
        state = "verified" if file["verified"] else "NOT whole"
        extent = f"{result['iterations']} iterations and the third act"
        lines.append(f"recording: {file['file']}, {file['bytes'] / 1e6:.1f} MB, {extent}, {state}")
        lines.append(f"           open it with `incsvr view {file['file']}`")
    lines.append(f"{result['seconds']} s in all; the report is {out / 'report.json'}")
    return "\n".join(lines)


def _table(table: Mapping[str, Any] | None) -> list[str]:
    """Table I's rows for both policies: the paper's, this experiment's, the mean of the published seeds."""
    if table is None:
        return ["Table I is not made: the benchmarks are not installed (pip install '.[bench]')"]
    published = table["published"]
    means = {} if published is None else {(row["regressor"], row["validation"]): row for row in published["rows"]}
    seeds = "" if published is None else f"mean of {published['seeds']} seeds"
    lines = [
        "Table I: mean absolute and root-mean-square error [N m], support vectors",
        f"{'':25s}{'the paper':19s}{'this run':19s}{seeds}".rstrip(),
    ]
    for row in table["rows"]:
        if row["paper"] is None or ("(" in row["regressor"] and row["learner"] != "weighted"):
            continue
        key = row["regressor"], row["validation"]
        figures = [row["paper"], row, means.get(key)]
        cells = [
            f"{each['mae']:.2f}  {each['rmse']:.2f}  {each['support_vectors']:4.0f}" if each else "" for each in figures
        ]
        lines.append(f"{f'{key[0]} on {key[1]}':25s}" + "".join(f"{cell:19s}" for cell in cells).rstrip())
    lines += [
        "B: offline, all samples at once; IncSVR: the learner after its last iteration.",
        "All by the sum of kernels alone; V1 and V2 above by the served model,",
        "which extrapolates beyond the learned rates.",
    ]
    if published is not None and published["why"]:
        lines += [line for part in published["why"].splitlines() for line in textwrap.wrap(part, WIDTH)]
    return [*lines, ""]
