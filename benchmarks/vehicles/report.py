"""The study of measured vehicles as tables that people read."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from benchmarks.tables import table
from incsvr.plant.axes import AXES

Record = Mapping[str, Any]
TRIVIAL, OURS = ("zero", "hold"), ("incsvr fit", "incsvr fit, M declared", "incsvr trace")


def report(document: Record) -> str:
    """Markdown."""
    records = document["splits"]
    lost = sum(bool(_beaten(record)) for record in records)
    versions = ", ".join(f"{name} {document['versions'][name]}" for name in ("pysindy", "sysidentpy", "scikit-learn"))
    parts = [
        "# What is predicted of measured vehicles",
        f"Made by `{document['command']}` on {document['date']}, one core of {document['processor']}; {versions}. The "
        "splits stand in `benchmarks/vehicles/splits.py` and were stated before any figure of this study was seen. All "
        "errors are root mean squares on recordings that were not fitted, in rad/s (yaw) or m/s. A free run begins at "
        "the first measured velocity of each recording and sees the torque (force) and the other recorded velocities "
        "alone. *Before* and *after* are the declared model and the traced one as `incsvr trace` reports them, with "
        "the 95 % interval of the change.",
        f"In {lost} of {len(records)} splits another method's free run errs less than ours, or a trivial one's; "
        "there the other is in bold.",
        _summary(records),
        "## Every method",
        "Free run, then multi-step errors at so many time scales of the motion; the seconds are those of the fit "
        "(of the tracer with its proof). What each method is given: `benchmarks/vehicles/peers.py`.",
    ]
    for record in records:
        parts += [f"### {record['split']}", _about(record), _methods(record)]
    skipped = [[each["vehicle"], each["axis"], each["why"]] for each in document["skipped"]]
    parts += ["## Axes that were skipped", table(["vehicle", "axis", "why"], skipped)]
    if document["absent"]:
        parts.append(f"Not there: {', '.join(document['absent'])}.")
    return "\n\n".join(parts) + "\n"


def _summary(records: list[Record]) -> str:
    rows = []
    for record in records:
        traced, errors = record["trace"], {name: row.get("free_run") for name, row in record["rows"].items()}
        peers = {name: error for name, error in errors.items() if error is not None and name not in TRIVIAL + OURS}
        best = min(peers, key=lambda name: peers[name])
        rival = f"{best} {peers[best]:.4g}"
        row = [
            record["split"] + f" ({record['about']})" * bool(record["about"]),
            f"{errors['zero']:.4g}",
            f"{errors['hold']:.4g}",
            f"**{rival}**" if _beaten(record) else rival,
            _number(errors["incsvr fit"]),
            _number(errors.get("incsvr fit, M declared")),
        ]
        if traced is None:
            row += ["–", "–", "–", record["rows"]["incsvr trace"]["failed"], "no"]
        else:
            change = traced["change"]
            row += [
                f"{traced['before']:.4g}",
                f"{traced['after']:.4g}",
                f"{change['low']:+.3g} to {change['high']:+.3g}",
                ", ".join(_named(each) for each in traced["named"]) or f"nothing ({traced['verdict']})",
                "yes" if traced["proven"] else "no",
            ]
        rows.append(row)
    head = [
        "split",
        "zero",
        "hold",
        "best other method",
        "fit",
        "fit, M",
        "before",
        "after",
        "change, 95 %",
        "named",
        "proven",
    ]
    return table(head, rows)


def _beaten(record: Record) -> bool:
    """Whether any other method's free run errs less than both of ours."""
    errors = {name: row["free_run"] for name, row in record["rows"].items() if "free_run" in row}
    ours = min((errors[name] for name in OURS if name in errors), default=float("inf"))
    return any(error < ours for name, error in errors.items() if name not in OURS)


def _named(finding: Record) -> str:
    values = ", ".join(f"{key} {value:.3g}" for key, value in finding["parameters"].items())
    return f"{finding['effect']} ({values})"


def _about(record: Record) -> str:
    axis = AXES[record["axis"]]
    fitted, unseen = record["minutes"]
    declared = f"{'m' if axis.along else 'I'} = {record['inertia']:g} {'kg' if axis.along else 'kg m²'}"
    return (
        f"{declared} ({record['source']}), time scale {record['time_scale']:.3g} s, {fitted:.1f} min fitted, "
        f"{unseen:.1f} min unseen" + f"; {record['about']}" * bool(record["about"]) + "."
    )


def _methods(record: Record) -> str:
    horizons = list(next(row["ahead"] for row in record["rows"].values() if "ahead" in row))
    rows = []
    for name, row in record["rows"].items():
        if "failed" in row:
            rows.append([name, "–", *["–"] * len(horizons), f"{row['seconds']:.2f}", row["failed"]])
            continue
        ahead = [_number(row["ahead"][horizon]) for horizon in horizons]
        rows.append([name, _number(row["free_run"]), *ahead, f"{row['seconds']:.2f}", ""])
    return table(["method", "free run", *(f"{horizon} T_c" for horizon in horizons), "s", "why not"], rows)


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"
