"""The command line: finds a command, hands it its arguments, turns bad input into one sentence.

This is the place where the project is put together. Commands are named as text and loaded when they are called, so
that the learner's process never holds what only the viewer or a benchmark needs.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import os
import sys
from collections.abc import Collection, Sequence

from incsvr.errors import BadInput, Failed
from service.cli.extras import how_to_install
from service.cli.parser import Parser
from service.cli.progress import without_bars
from service.cli.terminal import spelt_controls

COMMANDS = {
    "demo": (
        "service.commands.demo",
        "runs the paper's experiment end to end: simulator, learner and viewer, one recording, one report",
        "incsvr demo --out out",
    ),
    "serve": ("service.commands.serve", "runs the learner on the bus", "incsvr serve --config config.yaml"),
    "simulate": ("simulator.simulate", "publishes a simulated vehicle (Leng) on the bus", "incsvr simulate --speed 10"),
    "replay": ("simulator.replay", "publishes recordings on the bus", "incsvr replay dive.csv --speed 10"),
    "view": (
        "viewer.view",
        "shows a learner or a recording in the viewer, and records",
        "incsvr view --save dive.rrd",
    ),
    "page": (
        "viewer.page.server",
        "serves a learner's status, curve and effects to a browser",
        "incsvr page --port 9110",
    ),
    "query": ("service.commands.query", "asks a running learner for the damping", "incsvr query -0.2 0.05 0.1"),
    "status": (
        "service.commands.status",
        "shows which inputs arrive, what is learned and, if learning stopped, why; exit status 0 if health is OK",
        "incsvr status --json -",
    ),
    "inspect": (
        "service.commands.inspect",
        "lists the contents of a log of any format and what would be learned from it, or what arrives on the bus",
        "incsvr inspect dive.BIN --topic RCOU",
    ),
    "convert": (
        "service.commands.convert",
        "converts logs of any format to one CSV recording",
        "incsvr convert dive.BIN dive.csv",
    ),
    "fit": (
        "service.commands.fit",
        "learns the damping curve from recordings, with the error of each iteration",
        "incsvr fit dive.csv --validate other.csv --inertia 1.1",
    ),
    "tune": (
        "service.commands.tune",
        "searches C, ε and γ over recordings (Section IV-B of the paper)",
        "incsvr tune dive.csv --inertia 1.1 --write config.yaml",
    ),
    "trace": (
        "service.commands.trace",
        "finds the physical effects that the model lacks, with the error before and after",
        "incsvr trace dive.csv --validate other.csv --inertia 1.1 --report report.html",
    ),
    "identify": (
        "service.commands.identify",
        "identifies a whole vehicle: all axes together, with intervals and errors on unseen dives",
        "incsvr identify dive.csv --validate other.csv --write vehicle.yaml",
    ),
    "compare": (
        "service.commands.compare",
        "compares dives of a vehicle, or stored tables of a fleet: inertias and drags, and in which dive they changed",
        "incsvr compare may.csv june.csv july.csv --table history.parquet",
    ),
    "forecast": (
        "service.commands.forecast",
        "predicts yaw rate and heading without a gyro, or under a planned torque",
        "incsvr forecast --torque 20 --seconds 10",
    ),
    "effects": (
        "service.commands.effects",
        "lists the effects that a running learner has found; an operator promotes or withdraws them",
        "incsvr effects promote torque_lag",
    ),
    "export": (
        "service.export.command",
        "writes the learned model for other tools: tables and simulators",
        "incsvr export --format gazebo --out yaw.sdf",
    ),
    "table1": (
        "benchmarks.table1",
        "computes Table I and the curve of Fig. 7 beside the paper's figures",
        "incsvr table1 --seeds 5",
    ),
    "bench": (
        "benchmarks.bench",
        "measures speed beside other libraries, in one run",
        "incsvr bench --without-bus",
    ),
    "keys": (
        "service.commands.keys",
        "makes certificates and Zenoh files by role, for a secured bus",
        "incsvr keys tls --role learner --role vehicle",
    ),
    "config": (
        "service.commands.config",
        "checks a configuration, or shows the values in force",
        "incsvr config check config.yaml",
    ),
    "completion": (
        "service.cli.completion",
        "prints a script with which a shell completes commands and flags",
        "incsvr completion bash > ~/.local/share/bash-completion/completions/incsvr",
    ),
}
"""The module of each command, what it does, and an example."""
ALIASES = {"watch": ["status", "--follow"]}
"""Earlier names of commands, for one release."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command. Exit status: 0 done, 2 bad input (one sentence, no traceback), 1 failed."""
    with spelt_controls():
        return _run(list(sys.argv[1:] if arguments is None else arguments))


def _run(words: list[str]) -> int:
    if words and words[0] in ALIASES:
        named = ALIASES[words[0]]
        print(f"incsvr {words[0]}: use `incsvr {' '.join(named)}`; the next release has no {words[0]}", file=sys.stderr)
        words = [*named, *words[1:]]
    chosen = words[0] if words and words[0] in COMMANDS else None
    if chosen == "serve":
        # Read by NumPy when it is loaded: on matrices of the learner's size further threads only cost.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        # Only the command that was asked for is loaded: the others contribute their name and sentence alone.
        parser = parser_of([] if chosen is None else [chosen])
    except ModuleNotFoundError as error:
        missing = f"the package {error.name} is not installed"
        print(f"incsvr {chosen}: {missing}: {how_to_install(error.name or '')}", file=sys.stderr)
        return 2
    if not words:
        parser.print_help(sys.stderr)
        return 2
    args = parser.parse_args(words)
    try:
        with without_bars(getattr(args, "json", None) is not None):
            return int(args.run(args))
    except BadInput as error:
        print(f"incsvr {args.command}: {error}", file=sys.stderr)
        return 2
    except Failed as error:
        print(f"incsvr {args.command}: {error}", file=sys.stderr)
        return 1
    except BrokenPipeError:
        # The reader of our output went away (`incsvr fit … | head`): nothing is left to say.
        sys.stderr.close()
        return 1


def parser_of(loaded: Collection[str]) -> Parser:
    """The parser of the command line; the commands in `loaded` with their arguments, the others by name alone.

    Raises:
        ModuleNotFoundError: a command in `loaded` needs a package that is not installed.
    """
    parser = Parser(prog="incsvr", description="Learns a vehicle's yaw damping while it moves.", example="incsvr demo")
    parser.add_argument("--version", action="version", version=f"incsvr {importlib.metadata.version('incsvr')}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, (module, sentence, example) in COMMANDS.items():
        described = f"{sentence[0].upper()}{sentence[1:]}."
        command = commands.add_parser(name, help=sentence, description=described, example=example)
        if name in loaded:
            found = importlib.import_module(module)
            found.add_arguments(command)
            command.set_defaults(run=found.run)
    return parser


def whole_parser() -> Parser:
    """The parser with the arguments of every command whose packages are installed."""
    loaded = []
    for name, (module, _, _) in COMMANDS.items():
        try:
            importlib.import_module(module)
        except ModuleNotFoundError:
            continue
        loaded.append(name)
    return parser_of(loaded)


if __name__ == "__main__":
    sys.exit(main())
