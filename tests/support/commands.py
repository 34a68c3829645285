"""`dock-gateway` as a user calls it, at a gateway that runs."""

import os

from tests.support.processes import ForkedProcess


def command(url: str, *words: str) -> tuple[int, str]:
    """Run a command; return its exit code and what it printed."""
    with ForkedProcess("dock-gateway", *words, env={**os.environ, "DOCK_GATEWAY_URL": url}) as process:
        return process.wait(), process.output
