"""Missions made by chance. Each step that a robot carries out has a tag, by which it is found again at the robot."""

import random
from typing import Any

Step = dict[str, Any]


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

    def make(self, robot: str) -> tuple[str, dict[str, Any]]:
        """Return the id of a mission for a robot, and the body of the request."""
        self._mission += 1
        self._tags = 0
        steps = [self._step(robot) for _ in range(self._draw.randint(1, 6))]
        if len(steps) > 2 and self._draw.random() < 0.3:
            steps[-1]["name"] = "last"
            for step in steps[:-1]:
                if self._draw.random() < 0.3:
                    step["on_failure"] = {"go_to": "last"}
        return f"m{self._mission}", {"steps": steps, "priority": self._draw.choice([20, 50, 50, 50, 80])}

    def schedule(self, robot: str) -> dict[str, Any]:
        """Return a schedule for a robot: every few minutes it works, and docks."""
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
            "every": {"minutes": self._draw.randint(1, 4)},
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

    def _single(self, robot: str, *, inside: bool = False) -> Step:
        draw = self._draw
        kind = draw.choices(
            ["work", "dock", "undock", "seconds", "battery", "person", "call", "notify"], [6, 4, 3, 2, 1, 0.4, 2, 0.5]
        )[0]
        step: Step = {"tries": draw.choice([1, 1, 2, 3]), "timeout_s": draw.choice([None, None, 30, 120, 600])}
        if not inside:
            step["on_failure"] = self._policy()
        if kind == "work":
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
