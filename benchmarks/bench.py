"""`incsvr bench`: measures speed beside other libraries, in one run; the bus's figures too."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from typing import Any

from incsvr.errors import BadInput
from service.cli.extras import how_to_install
from service.cli.output import add_json_argument, emit
from service.cli.progress import progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--seeds", type=int, default=20, metavar="N", help="repetitions of the experiment (20)")
    parser.add_argument(
        "--without-bus", action="store_true", help="the mathematics alone, without the two minutes of Zenoh"
    )
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    if args.seeds < 1:
        raise BadInput(f"--seeds {args.seeds}: give at least one repetition")
    try:
        # Here and not above: whoever asks for --help needs none of it, and the peers are extras.
        from benchmarks import bus, learner_times
        from benchmarks.study import provenance
    except ModuleNotFoundError as error:
        raise BadInput(f"{error.name}, one of the peers, is missing: {how_to_install(error.name or '')}") from None
    from threadpoolctl import threadpool_limits

    result: dict[str, Any] = {"measured": provenance("incsvr bench", "scikit-learn", "eclipse-zenoh")}
    with threadpool_limits(1), progress("measuring", args.seeds + 2 + (not args.without_bus)) as advance:
        result |= learner_times.measure(args.seeds, advance=advance)
        result["solver"] = learner_times.solver()
        advance()
        if not args.without_bus:
            result |= bus.measure()
            advance()
    emit(args, result, text(result))
    return 0


def text(result: dict[str, Any]) -> str:
    """What must be reached first, then every figure."""
    measured = result["measured"]
    lines = [
        f"{measured['command']}, {measured['date']}, {measured['processor']}, one core",
        "",
        *(_step(policy, figures) for policy, figures in result["policies"].items()),
        f"the solver alone      {_beside(result['solver'])}; {_beside(result['solver']['offline'])}",
        f"certified error       at most {result['certified_error_nm']:.2g} N m in {result['seeds']} repetitions",
        "",
        *_lines(result),
    ]
    return "\n".join(lines)


def _step(policy: str, figures: Mapping[str, Any]) -> str:
    step, ratio = figures["step_ms"], figures["ratio_to"]
    return (
        f"a step, {policy:<14s}{step['median']:.2f} ms (p99 {step['p99']:.2f}) for n = "
        f"{figures['samples_trained_on']['median']:.0f}, where SVR.fit takes {ratio['sklearn_svr_fit']:.2f} × and "
        f"Eq. 8's passes to a relative gap of 1e-2 take {ratio['coordinate_descent']:.0f} × as long"
    )


def _beside(figures: Mapping[str, Any]) -> str:
    return (
        f"{figures['solve_ms']['median']:.2f} ms for n = {figures['n']}, where SVR.fit takes "
        f"{figures['ratio_to_sklearn_svr_fit']:.1f} × as long"
    )


def _lines(figures: Mapping[str, Any], indent: int = 0) -> Iterator[str]:
    for name, value in figures.items():
        if isinstance(value, Mapping):
            yield " " * indent + name
            yield from _lines(value, indent + 2)
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            yield " " * indent + name
            for entry in value:
                yield " " * (indent + 2) + ", ".join(f"{key} {_short(item)}" for key, item in entry.items())
        else:
            yield f"{' ' * indent}{name:<{max(1, 36 - indent)}s} {_short(value)}"


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
