"""Missions made by chance. Each step that a robot carries out has a tag, by which it is found again at the robot."""

import random
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

Step = dict[str, Any]

# The template that people have stored, and its id.
TEMPLATE_ID = "errand"
TEMPLATE: Mapping[str, Any] = {
    "priority": 50,
    "battery": {"below": 0.3, "charge_to": 0.7},
    "parameters": {"work": {}, "first": {}, "second": {}, "third": {}},
    "steps": [
        {
            "action": {"name": "$work", "goal": {"tag": "$first"}},
            "interruptible": True,
            "on_failure": "next",
            "timeout_s": 600,
        },
        {"action": {"name": "$work", "goal": {"tag": "$second"}}, "tries": 2, "on_failure": "next", "timeout_s": 600},
        {"dock": {"tag": "$third"}, "tries": 3},
    ],
}
# How many steps of a mission of the template have tags.
TAGS = 3


@dataclass(frozen=True)
class Made:
    """A mission.

    Attributes:
        mission_id: Its id.
        request: The body of the request.
        steps: What that comes to.
    """

    mission_id: str
    request: Mapping[str, Any]
    steps: list[Step]


class RandomMissions:
    """Makes missions.

    Args:
        draw: Decides everything.
        docks: The names of the docks.
    """

    def __init__(self, draw: random.Random, docks: list[str]) -> None:
        self._draw = draw
        self._docks = docks
        self._mission = 0
        self._tags = 0

    def make(self, robot: str) -> Made:
        """Return a mission for a robot."""
        mission_id = self._next()
        if self._draw.random() < 0.15:
            return self._of_template(mission_id, robot)
        steps = [self._step(robot) for _ in range(self._draw.randint(1, 6))]
        if len(steps) > 2 and self._draw.random() < 0.3:
            steps[-1]["name"] = "last"
            for step in steps[:-1]:
                if self._draw.random() < 0.3:
                    step["on_failure"] = {"go_to": "last"}
        return self._made(mission_id, steps)

    def make_for_group(self, group: str) -> Made:
        """Return a mission for any robot of a group: it has only steps that each robot can carry out."""
        mission_id = self._next()
        steps = [self._single(None) for _ in range(self._draw.randint(1, 4))]
        return self._made(mission_id, steps, group=group)

    def _next(self) -> str:
        self._mission += 1
        self._tags = 0
        return f"m{self._mission}"

    def _made(self, mission_id: str, steps: list[Step], **more: Any) -> Made:
        battery = {}
        if self._draw.random() < 0.6:
            limits = {"below": self._draw.uniform(0.15, 0.4), "charge_to": self._draw.uniform(0.5, 0.9)}
            battery = {"battery": limits}
        request = {"steps": steps, "priority": self._draw.choice([20, 50, 50, 50, 80])}
        return Made(mission_id, request | battery | more, steps)

    def _of_template(self, mission_id: str, robot: str) -> Made:
        first, second, third = (self._tag() for _ in range(TAGS))
        arguments = {"work": f"{robot}/work", "first": first, "second": second, "third": third}
        steps = [{"action": {"name": f"{robot}/work", "goal": {"tag": tag}}} for tag in (first, second)]
        request = {"template": TEMPLATE_ID, "arguments": arguments}
        return Made(mission_id, request, [*steps, {"dock": {"tag": third}}])

    def schedule(self, robot: str, minutes: int) -> dict[str, Any]:
        """Return a schedule for a robot: every one to four times so many minutes it works, and docks."""
        tag = f"s{robot[1:]}"
        work = {
            "action": {"name": f"{robot}/work", "goal": {"tag": f"{tag}.1"}},
            "on_failure": "next",
            "timeout_s": 200,
        }
        dock = {"dock": {"dock_id": self._draw.choice(self._docks), "tag": f"{tag}.2"}, "on_failure": "next"}
        return {
            "robot": robot,
            "mission": {"steps": [work, dock], "priority": self._draw.choice([20, 50, 80])},
            "every": {"minutes": minutes * self._draw.randint(1, 4)},
            "if_running": self._draw.choice(["skip", "queue"]),
        }

    def _step(self, robot: str) -> Step:
        kind = self._draw.random()
        if kind < 0.08:
            inside = [self._single(robot) for _ in range(self._draw.randint(1, 3))]
            return {"repeat": {"steps": inside, "times": self._draw.randint(1, 3)}, "on_failure": self._policy()}
        if kind < 0.16:
            inside = [self._single(robot, inside=True) for _ in range(self._draw.randint(1, 3))]
            return {"first_that_works": inside, "on_failure": self._policy()}
        return self._single(robot)

    def _policy(self) -> str:
        return self._draw.choice(["end", "next", "next"])

    def _tag(self) -> str:
        self._tags += 1
        return f"m{self._mission}.{self._tags}"

    def _single(self, robot: str | None, *, inside: bool = False) -> Step:
        """Return a step of a robot; None: one that each robot can carry out."""
        draw = self._draw
        of_a_robot = 1 if robot is not None else 0
        kind = draw.choices(
            ["work", "dock", "undock", "seconds", "battery", "person", "call", "notify"],
            [6 * of_a_robot, 4, 3, 2, 1, 0.4, 2 * of_a_robot, 0.5],
        )[0]
        step: Step = {"tries": draw.choice([1, 1, 2, 3]), "timeout_s": draw.choice([None, None, 30, 120, 600])}
        if not inside:
            step["on_failure"] = self._policy()
        if kind == "work":
            step["interruptible"] = draw.random() < 0.5
            return step | {"action": {"name": f"{robot}/work", "goal": {"tag": self._tag()}}}
        if kind == "dock":
            named = {"dock_id": draw.choice(self._docks)} if draw.random() < 0.6 else {}
            return step | {"dock": named | {"tag": self._tag()}}
        if kind == "undock":
            return step | {"undock": {"tag": self._tag()}}
        if kind == "call":
            return step | {"call": {"service": f"{robot}/reset", "request": {"tag": self._tag()}}}
        if kind == "notify":
            return step | {"notify": {"text": "Hello"}}
        wait: Step = {"person": True}
        if kind == "seconds":
            wait = {"seconds": draw.uniform(0, 300)}
        elif kind == "battery":
            wait = {"battery": draw.uniform(0.1, 0.6)}
        return step | {"wait": wait}
