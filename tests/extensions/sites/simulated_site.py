"""Simulated sites as a process: `python -m tests.extensions.sites.simulated_site --broker URL --keys FILE berlin …`.

What is simulated is only the gateway's own API: connection, hello, tunnel and verification are those of a real site.
The clock may be off, for all code of the process.
"""

import argparse
import time
from pathlib import Path


def read_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    parser.add_argument("sites", nargs="+")
    parser.add_argument("--brokers", type=Path, required=True, help="JSON file: the broker's URL for each site")
    parser.add_argument("--keys", type=Path, required=True, help="what `dock-gateway hub key` prints")
    parser.add_argument("--robots", type=int, default=3)
    parser.add_argument("--journals", type=Path, help="folder for what outlives the process")
    parser.add_argument("--clock-offset", type=float, default=0.0, help="seconds by which the clock is ahead")
    parser.add_argument("--change-period", type=float, default=0.0, help="seconds; 0: robots do not change")
    parser.add_argument("--port", type=int, help="where the first site listens itself, too")
    return parser.parse_args()


if __name__ == "__main__":
    arguments = read_arguments()
    real, offset = time.time, arguments.clock_offset
    time.time = lambda: real() + offset

    from tests.extensions.sites.site_process import run  # everything that asks for the time comes after it was set

    run(arguments)
