"""The hall of simulated robots, as it really is: who stands on which dock, and whose battery is empty."""

import os
import random
import signal
from pathlib import Path
from typing import Any

from geometry_msgs.msg import TransformStamped

from docking.simulation.hall import Hall
from tests.support.observer import Observer
from tests.support.processes import Process

# A robot whose middle is nearer to where docked robots stand than this, in m, stands on the dock or touches it.
ON_DOCK = 0.1


class Watch:
    """Hears where each robot is in truth, and notes who stood on which dock.

    Args:
        observer: The test's node.
        hall: The docks.

    Attributes:
        stays: Each stay on a dock: its name, the robot, and from when to when it was seen there, in s since 1970.
    """

    def __init__(self, observer: Observer, hall: Hall) -> None:
        self._places = {name: hall.docked(number) for number, name in enumerate(hall.dock_names, 1)}
        self._on: dict[str, tuple[str, float]] = {}
        self.stays: list[tuple[str, str, float, float]] = []
        record = observer.record(TransformStamped, "/simulated_robots")
        record.wait_for_publisher()
        self._messages: list[Any] = record.messages

    def look(self, now: float) -> None:
        """Take in what has come.

        Args:
            now: In s since 1970.
        """
        count = len(self._messages)
        for message in self._messages[:count]:
            robot, place = f"/{message.child_frame_id.partition('/')[0]}", message.transform.translation
            near = (n for n, at in self._places.items() if (at.x - place.x) ** 2 + (at.y - place.y) ** 2 < ON_DOCK**2)
            dock = next(near, None)
            before, since = self._on.get(robot, (None, now))
            if before is not None and before != dock:
                self.stays.append((before, robot, since, now))
                del self._on[robot]
            if dock is not None:
                self._on.setdefault(robot, (dock, now))
        del self._messages[:count]

    def end(self, now: float) -> None:
        """End the stays that go on."""
        self.look(now)
        self.stays += [(dock, robot, since, now) for robot, (dock, since) in self._on.items()]
        self._on.clear()


def kill_a_robot(fleet: Process) -> None:
    """End the process of one of the robots; the fleet starts it again, where robots start, with the battery of then."""
    children = Path(f"/proc/{fleet.pid}/task/{fleet.pid}/children").read_text().split()
    os.kill(int(random.choice(children)), signal.SIGKILL)
