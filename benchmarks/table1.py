"""`incsvr table1`: Table I and the curve of Fig. 7 beside the paper's figures, on the simulated experiment.

Every figure is the mean over the seeds, with its standard deviation from seed to seed. One seed is one repetition of
the whole experiment: T1 and then T2 to train on, V1 and V2 to validate with. B1 and B2 search their hyper-parameters
anew for every seed (five folds over the paper's grid); the learners keep the paper's.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from typing import Any

import numpy as np

from benchmarks.chart import chart
from benchmarks.provenance import provenance
from benchmarks.repetition import LEARNERS, USUAL, Repetition, repetitions
from incsvr.errors import BadInput
from incsvr.learning.learner import Settings
from incsvr.samples import Array
from service.output import add_json_argument, emit
from simulator.progress import progress

PAPER = {
    ("B1", "V1"): (3.14, 3.94, 418),
    ("IncSVR1", "V1"): (3.26, 4.36, 60),
    ("B1", "V2"): (5.65, 7.6, 418),
    ("B2", "V2"): (3.44, 4.48, 538),
    ("IncSVR2", "V2"): (3.52, 4.61, 60),
}
"""Table I: MAE and RMSE [N m], active support vectors."""
CONVERGED = 0.03
"""A learner has converged once its error stays within this part of its final error."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--seeds", type=int, default=20, metavar="N", help="repetitions of the experiment (20)")
    parser.add_argument("--passes", action="store_true", help="also the paper's learner with Eq. 8's passes (minutes)")
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    if args.seeds < 1:
        raise BadInput(f"--seeds {args.seeds}: give at least one repetition")
    done = []
    with progress("repetitions", args.seeds) as advance:
        for repetition in repetitions(args.seeds, tuple(LEARNERS) if args.passes else USUAL):
            done.append(repetition)
            advance()
    result = summary(done) | {"measured": provenance(f"incsvr table1 --seeds {args.seeds}" + " --passes" * args.passes)}
    emit(args, result, text(result))
    return 0


def summary(repetitions: list[Repetition]) -> dict[str, Any]:
    """The contract's form: means over the repetitions. IncSVR1 and IncSVR2 are the default learner's."""
    default = Settings().policy
    rows = []
    for name, learner, validation in repetitions[0].rows:
        values = np.array([repetition.rows[name, learner, validation] for repetition in repetitions])
        mean, spread = values.mean(axis=0), values.std(axis=0, ddof=min(1, len(repetitions) - 1))
        paper = PAPER.get((name, validation))
        rows.append(
            {
                "regressor": name if learner in ("", default) else f"{name} ({learner})",
                "validation": validation,
                **_named(mean),
                "spread": _named(spread),
                "learner": learner or None,
                "paper": None if paper is None else _named(paper),
            }
        )
    learners = {learner: _learner(learner, repetitions) for learner in repetitions[0].old_model}
    return {
        "seeds": len(repetitions),
        "rows": sorted(rows, key=_place),
        "iterations_to_converge": learners[default]["iterations_to_converge"],
        "mae_per_iteration": learners[default]["mae_per_iteration"],
        "default_learner": default,
        "learners": learners,
    }


def _learner(learner: str, repetitions: list[Repetition]) -> dict[str, Any]:
    curves = {
        validation: np.mean([repetition.curves[learner, validation] for repetition in repetitions], axis=0)
        for validation in ("V1", "V2")
    }
    ratios = {
        validation: [
            repetition.rows[regressor, learner, validation][0] / repetition.rows[offline, "", validation][0]
            for repetition in repetitions
        ]
        for regressor, offline, validation in (("IncSVR1", "B1", "V1"), ("IncSVR2", "B2", "V2"))
    }
    return {
        "iterations_to_converge": [converged(curves["V1"]), converged(curves["V2"])],
        "mae_per_iteration": {validation: curve.tolist() for validation, curve in curves.items()},
        "old_model_on_V2": float(np.mean([repetition.old_model[learner] for repetition in repetitions])),
        "ratio_to_offline": {validation: float(np.mean(values)) for validation, values in ratios.items()},
        "ratio_spread": {
            validation: float(np.std(values, ddof=min(1, len(values) - 1))) for validation, values in ratios.items()
        },
    }


def converged(curve: Array) -> int:
    """After how many iterations the error (n,) stays within CONVERGED of its final value."""
    away = np.flatnonzero(np.abs(curve - curve[-1]) > CONVERGED * curve[-1])
    return int(away[-1]) + 2 if away.size else 1


def _named(values: Iterable[float]) -> dict[str, float]:
    return dict(zip(("mae", "rmse", "support_vectors"), map(float, values), strict=True))


def _place(row: dict[str, Any]) -> tuple[int, int, int]:
    """Table I's order; the default learner above the other; what is not in the table last."""
    name = row["regressor"].split(" (")[0]
    known = list(PAPER)
    place = known.index((name, row["validation"])) if (name, row["validation"]) in known else len(known)
    return place, int(row["regressor"] != name), int(row["validation"][1])


def text(result: dict[str, Any]) -> str:
    """Table and curve for people."""
    lines = [
        f"{result['measured']['command']}, {result['measured']['date']}",
        f"Table I, mean ± standard deviation over {result['seeds']} repetitions; the paper's figure in brackets",
        "",
        "regressor                 on   MAE N m                RMSE N m               support vectors",
    ]
    for row in result["rows"]:
        cells = [f"{row['regressor']:<25s} {row['validation']}  "]
        for key, digits in (("mae", 2), ("rmse", 2), ("support_vectors", 0)):
            figure = f"{row[key]:.{digits}f} ± {row['spread'][key]:.{digits}f}"
            paper = f" ({row['paper'][key]:.{digits}f})" if row["paper"] else ""
            cells.append(f"{figure + paper:<22s} ")
        lines.append("".join(cells).rstrip())
    for learner, figures in result["learners"].items():
        ratio, spread = figures["ratio_to_offline"], figures["ratio_spread"]
        first, second = figures["iterations_to_converge"]
        lines += [
            "",
            f"{learner}: MAE over the offline SVR's {ratio['V1']:.3f} ± {spread['V1']:.3f} on V1, "
            f"{ratio['V2']:.3f} ± {spread['V2']:.3f} on V2;",
            f"  within {CONVERGED:.0%} of the final error after {first} iterations, with the hull after {second} more "
            f"(paper 12, 10); the old model on V2 {figures['old_model_on_V2']:.2f} N m",
        ]
    curves = {
        learner: [
            *figures["mae_per_iteration"]["V1"],
            figures["old_model_on_V2"],
            *figures["mae_per_iteration"]["V2"],
        ]
        for learner, figures in result["learners"].items()
    }
    jump = len(result["mae_per_iteration"]["V1"]) + 1
    title = f"Fig. 7: MAE [N m] per iteration: on V1; at {jump} the hull comes and the old model meets V2; then on V2"
    top = max(curve[jump - 1] for curve in curves.values())
    return "\n".join([*lines, "", title, chart(curves, top)])
