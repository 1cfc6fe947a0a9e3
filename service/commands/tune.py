"""`incsvr tune`: the grid search of Section IV-B over recordings, with every point of the grid and its ranks."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.learner import Settings
from incsvr.learning.scaling import PAPER_RATE, PAPER_TORQUE
from incsvr.learning.tuning import PAPER_POINT, Grid, Judged, Trial, ranked, search
from incsvr.signals.samples import Samples
from service.cli.output import add_json_argument, emit, refuse_replacing
from service.cli.progress import progress
from service.commands.arguments import POLICY_HELP
from service.config.configuration import Config
from service.config.sources import read as read_config
from service.fitting import scaled
from service.fitting.declared import Declared
from service.fitting.request import POLICIES, Request
from service.fitting.settings import as_configured, settings
from service.recordings.reading import add_log_arguments
from service.recordings.recording import sequence

EXPERIMENT = "simulator.leng"
"""Simulates the paper's experiment; loaded when asked for."""
_JUDGED_BY: dict[Judged, str] = {"every": "after every step, averaged", "last": "after the last step alone"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("recordings", nargs="*", type=Path, metavar="RECORDING", help="logs of any format")
    parser.add_argument(
        "--simulated",
        type=int,
        metavar="SEED",
        help="tune on T1 of the simulated Leng with this seed instead of recordings",
    )
    parser.add_argument("--inertia", metavar="I", help="inertia with added mass [kg m²], or estimate")
    parser.add_argument("--config", type=Path, metavar="FILE", help="signals and learner as the service has them")
    parser.add_argument("--policy", choices=POLICIES, help=POLICY_HELP)
    parser.add_argument("--last", action="store_true", help="judge after the last step alone, not after every step")
    parser.add_argument("--write", type=Path, metavar="FILE", help="write a configuration with the best point")
    add_log_arguments(parser)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    judged: Judged = "last" if args.last else "every"
    if (args.simulated is None) == (not args.recordings):
        raise BadInput("give recordings to tune on, or --simulated SEED for the simulated Leng's T1")
    if args.write is not None:
        refuse_replacing(args.write, scaled.MARK, "--write")
    config = read_config(args.config).of_axis(args.axis)
    if config.further_inputs:
        raise BadInput("the search is over one velocity; leave learner.inputs out of the configuration")
    name, samples, learner, grid, config = (
        _simulated(args, config) if args.recordings == [] else _recorded(args, config)
    )
    with progress("points of the grid", len(grid)) as advance:
        trials = []
        for trial in search(samples, learner, grid):
            trials.append(trial)
            advance()
    tuning = Tuning(name, len(samples), grid, judged, ranked(trials, judged), ranked(trials, _other(judged)))
    if args.write is not None:
        _write(args.write, config, tuning)
    emit(args, tuning.to_dict(), tuning.text() + (f"\n\nwritten to {args.write}" if args.write else ""))
    return 0


@dataclass(frozen=True, slots=True)
class Tuning:
    """The result of the search.

    Attributes:
        name: the recordings, joined.
        samples: how many there were.
        grid: what was tried.
        judged: by which error the trials are ranked.
        trials: all points, the best first.
        otherwise: the same points, ranked by the other error.
    """

    name: str
    samples: int
    grid: Grid
    judged: Judged
    trials: Sequence[Trial]
    otherwise: Sequence[Trial]

    def __post_init__(self) -> None:
        assert len(self.trials) == len(self.grid)

    @property
    def best(self) -> Settings:
        return self.trials[0].settings

    def is_papers(self, trial: Trial) -> bool:
        """Whether it is the point that the paper's search chose, by its place in the grid."""
        C, epsilon, gamma = PAPER_POINT
        paper, grid = Grid(), self.grid
        place = (paper.C.index(C), paper.epsilon.index(epsilon), paper.gamma.index(gamma))
        return trial.point == (grid.C[place[0]], grid.epsilon[place[1]], grid.gamma[place[2]])

    def to_dict(self) -> dict[str, Any]:
        others = {trial.point: rank for rank, trial in enumerate(self.otherwise, start=1)}
        return {
            "recordings": self.name,
            "samples": self.samples,
            "judged": self.judged,
            "best": dict(zip(("C", "epsilon", "gamma"), self.trials[0].point, strict=True)),
            "trials": [
                {
                    "rank": rank,
                    "C": trial.settings.C,
                    "epsilon": trial.settings.epsilon,
                    "gamma": trial.settings.gamma,
                    "mae_every_step": trial.every,
                    "mae_last_step": trial.last,
                    "rank_otherwise": others[trial.point],
                    "paper": self.is_papers(trial),
                }
                for rank, trial in enumerate(self.trials, start=1)
            ],
        }

    def text(self) -> str:
        """The result for people, in at most 80 columns."""
        count, batch = self.samples // self.best.batch, self.best.batch
        lines = [
            f"{self.name}: {self.samples} samples, {count} batches of {batch}, each left out once",
            "mean absolute error on the batch left out [N m]; ranked by the error",
            f"{_JUDGED_BY[self.judged]}; otherwise: the rank by the other column",
            "",
            "rank   C N m    ε N m   γ s²/rad²   every step   last step   otherwise",
        ]
        others = {trial.point: rank for rank, trial in enumerate(self.otherwise, start=1)}
        for rank, trial in enumerate(self.trials, start=1):
            C, epsilon, gamma = trial.point
            mark = "  paper's" if self.is_papers(trial) else ""
            lines.append(
                f"{rank:4d} {C:7.4g} {epsilon:8.3g} {gamma:11.4g} {trial.every:12.3f} {trial.last:11.3f} "
                f"{others[trial.point]:10d}{mark}"
            )
        return "\n".join(lines)


def _other(judged: Judged) -> Judged:
    return "every" if judged == "last" else "last"


def _simulated(args: argparse.Namespace, config: Config) -> tuple[str, Samples, Settings, Grid, Config]:
    learner = config.learner_settings()
    learner = learner if args.policy is None else replace(learner, policy=args.policy)
    samples = import_module(EXPERIMENT).experiment(args.simulated).T1
    return f"simulated T1, seed {args.simulated}", samples, learner, Grid(), config


def _recorded(args: argparse.Namespace, config: Config) -> tuple[str, Samples, Settings, Grid, Config]:
    """The samples and settings that `fit` would learn with; what is not configured is noted in the configuration."""
    request = Request.of(args)
    reading = request.reading(config)
    runs, _ = request.read(reading)
    declared = Declared.of(request, config, reading.axis, runs, runs).as_written
    signals, terms = settings(request, config, declared, runs, ())
    joined = sequence(runs)
    samples, _ = terms.samples(joined, signals)
    learner = terms.settings(joined, samples)
    config = declared.in_force(config)
    if not as_configured(request):
        config = scaled.scaled_config(config, joined, signals, learner)
    fastest, largest = np.abs(samples.yaw_rate).max(), np.abs(samples.damping).max()
    grid = Grid().scaled(_round(fastest / PAPER_RATE), _round(largest / PAPER_TORQUE))
    return joined.name, samples, learner, grid, config


def _round(factor: float) -> float:
    """Rounds to 1, 2 or 5 times a power of ten, because the steps of the grid are wider."""
    decade = 10.0 ** math.floor(math.log10(factor))
    return min((decade * step for step in (1.0, 2.0, 5.0, 10.0)), key=lambda each: abs(math.log(each / factor)))


def _write(path: Path, config: Config, tuning: Tuning) -> None:
    """The configuration with the best point."""
    C, epsilon, gamma = tuning.trials[0].point
    point = {"C": C, "epsilon": epsilon, "gamma": gamma, "policy": tuning.best.policy}
    tuned = config.model_copy(update={"learner": config.learner.model_copy(update=point)})
    head = (
        f"# C, ε and γ by `incsvr tune` on {tuning.name}, {tuning.samples} samples (Section IV-B), judged\n"
        f"# {_JUDGED_BY[tuning.judged]}.\n"
    )
    scaled.write(path, tuned, head)
