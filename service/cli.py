"""The command line: finds a command, hands it its arguments, turns bad input into one sentence.

This is the place where the project is put together. Commands are named as text and loaded when they are called, so
that the learner's process never holds what only the viewer or a benchmark needs.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Sequence

from incsvr.errors import BadInput
from service.progress import hidden

COMMANDS = {
    "demo": ("service.demo", "the main job, end to end: simulator, learner and viewer, one recording, one report"),
    "serve": ("service.serve", "the learner on the bus"),
    "simulate": ("simulator.simulate", "plays the Leng plant onto the keys"),
    "replay": ("simulator.replay", "plays recorded runs onto the keys"),
    "view": ("viewer.view", "live viewer, recording"),
    "query": ("service.query", "asks a running learner for the damping"),
    "status": ("service.status", "what a running learner hears, makes of it and why; exit status 0 where health is OK"),
    "watch": ("service.watch", "the same, live, and a line for each iteration"),
    "inputs": ("service.inputs_command", "what is heard on a vehicle's bus, how often, and whether it can be true"),
    "inspect": ("service.inspecting", "what is in a log of any format, and what of it would be learned from"),
    "convert": ("simulator.convert", "logs of any format as one recording in our form"),
    "fit": ("simulator.fit", "the online loop over recordings; errors for each iteration"),
    "tune": ("simulator.tune", "the grid search of Section IV-B for C, ε and γ over recordings"),
    "trace": ("simulator.trace", "finds what the model lacks, adds it, reports the error before and after"),
    "table1": ("benchmarks.table1", "Table I and the curve of Fig. 7 beside the paper's figures"),
    "bench": ("benchmarks.bench", "speed against the peers, measured in one run"),
    "keys": ("service.keys", "certificates and Zenoh files by role, for a secured bus"),
    "config": ("service.config_command", "what is in force, what is wrong"),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command. Exit status: 0 done, 2 bad input (one sentence, no traceback), 1 failed."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    parser = argparse.ArgumentParser(prog="incsvr", description="Learns a vehicle's yaw damping while it moves.")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, (module, sentence) in COMMANDS.items():
        # Only the command that was asked for is loaded: the others contribute their name and sentence alone.
        chosen = bool(words) and words[0] == name
        if chosen and name == "serve":
            # Read by NumPy when it is loaded: on matrices of the learner's size further threads only cost.
            os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        command = commands.add_parser(name, help=sentence, description=f"{sentence[0].upper()}{sentence[1:]}.")
        if chosen:
            try:
                loaded = importlib.import_module(module)
            except ModuleNotFoundError as error:
                missing = f"the package {error.name} is not installed"
                print(f"incsvr {name}: {missing}: pip install 'incsvr[viewer,report,bench,keys]'", file=sys.stderr)
                return 2
            loaded.add_arguments(command)
            command.set_defaults(run=loaded.run)
    args = parser.parse_args(words)
    try:
        with hidden(getattr(args, "json", None) is not None):
            return int(args.run(args))
    except BadInput as error:
        print(f"incsvr {args.command}: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        # The reader of our output went away (`incsvr fit … | head`): nothing is left to say.
        sys.stderr.close()
        return 1


if __name__ == "__main__":
    sys.exit(main())
