"""`incsvr completion SHELL`: a script by which a shell completes commands and flags."""

from __future__ import annotations

import argparse

import shtab


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shell", metavar="SHELL", choices=shtab.SUPPORTED_SHELLS, help="bash, zsh or tcsh")


def run(args: argparse.Namespace) -> int:
    # Here and not above: the command line names this module, and is what is completed.
    from service.cli.command_line import whole_parser

    print(shtab.complete(whole_parser(), args.shell))
    return 0
