"""What can be chosen on the command line."""

import argparse
from dataclasses import dataclass
from pathlib import Path

CASES = "abcdefghijk"


@dataclass(frozen=True)
class Options:
    """One run."""

    cases: str
    rounds: int
    goals: int
    seconds: float
    quiet: float
    payload: int
    robots: int
    peers: Path | None
    variants: tuple[tuple[str, Path], ...]
    tokens: bool
    output: Path


def read_options(arguments: list[str]) -> Options:
    """Out of the command line."""
    parser = argparse.ArgumentParser("benchmarks", description="Measure dock-gateway; see docs/performance.md")
    parser.add_argument("--cases", default=CASES, help="which of a b c d e f g h i j k (default: all)")
    parser.add_argument("--rounds", type=int, default=3, help="turns of each system in each case (default: 3)")
    parser.add_argument("--goals", type=int, default=150, help="goals in cases a, g and k (default: 150)")
    parser.add_argument("--seconds", type=float, default=4.0, help="length of one run of feedback (default: 4)")
    parser.add_argument("--quiet", type=float, default=10.0, help="seconds to wait for a quiet machine (default: 10)")
    parser.add_argument("--payload", type=int, default=0, help="bytes added to each feedback message")
    parser.add_argument("--robots", type=int, default=100, help="robots in case f (default: 100)")
    parser.add_argument("--short", action="store_true", help="streams of two seconds, 30 goals")
    parser.add_argument("--peers", type=Path, help="folder of the peers' environments (default: none are measured)")
    parser.add_argument(
        "--variant",
        action="append",
        default=[],
        metavar="NAME=PATH",
        help="also measure the gateway of another checkout, in which `make setup` was run",
    )
    parser.add_argument("--tokens", action="store_true", help="also measure the gateway with authentication")
    parser.add_argument("--output", type=Path, default=Path(__file__).parent / "results")
    read = parser.parse_args(arguments)
    if set(read.cases) - set(CASES):
        parser.error(f"--cases: some of {CASES}")
    variants = []
    for variant in read.variant:
        name, _, folder = variant.partition("=")
        if not (Path(folder) / ".venv/bin/dock-gateway").is_file():
            parser.error(f"--variant: there is no .venv/bin/dock-gateway in {folder!r}")
        variants.append((name, Path(folder).resolve()))
    return Options(
        cases=read.cases,
        rounds=read.rounds,
        goals=30 if read.short else read.goals,
        seconds=2.0 if read.short else read.seconds,
        quiet=read.quiet,
        payload=read.payload,
        robots=read.robots,
        peers=read.peers.resolve() if read.peers else None,
        variants=tuple(variants),
        tokens=read.tokens,
        output=read.output,
    )
