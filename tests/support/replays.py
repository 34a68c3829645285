"""Replay recordings, one after the other: python -m tests.support.replays FILE… Prints the exit code of each, in JSON.

The program starts once; each replay is a process of its own, as with `docking_replay`.
"""

import sys

from docking.nodes.replay import main

if __name__ == "__main__":
    print([main([file]) for file in sys.argv[1:]], flush=True)
