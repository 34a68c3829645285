"""A gateway imports nothing that only some gateways use."""

import subprocess
import sys


def test_without_a_hub_nothing_of_nats_is_imported() -> None:
    program = "import sys, dock_gateway.cli.gateway; print({'nats'} & sys.modules.keys())"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
