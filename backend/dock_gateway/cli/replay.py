"""`dock-gateway replay`: what our docking server would decide on the sensors of a recorded goal."""

import os

import click

from dock_gateway.cli.programs import find_program


@click.command(context_settings={"ignore_unknown_options": True})
@click.argument("recording", type=click.Path(exists=True, dir_okay=False, readable=True))
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED)
def replay(recording: str, arguments: tuple[str, ...]) -> None:
    """Replay a recorded goal, and print where the docking server would decide otherwise.

    RECORDING is a file of GET /goals/{goal_id}/recording.mcap. ROS arguments such as other parameters follow
    --ros-args. Nothing moves. The exit code is 0 if the goal takes the same course, 1 if not, 2 if it cannot be
    replayed, or if the recording does not allow a verdict.
    """
    program = find_program("docking_replay")
    os.execv(program, [program, recording, *arguments])  # noqa: S606 - our own program
