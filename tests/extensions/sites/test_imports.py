"""A gateway without a hub does not import what only a connection to one needs."""

import subprocess
import sys


def test_without_a_hub_nothing_of_nats_is_imported() -> None:
    program = (
        "import sys, dock_gateway.cli.gateway; from dock_gateway.extension import extensions; extensions(); "
        "print({'nats'} & sys.modules.keys())"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
