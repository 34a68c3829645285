"""People who queue missions at real gateways, hold them up, and let them go on."""

import itertools
import random
import time
import uuid
from collections import Counter
from collections.abc import Callable
from typing import Any

import httpx2

from tests.chaos.load import Worker
from tests.support.clients import HttpClient
from tests.support.waiting import PATIENCE

Step = dict[str, Any]
# Where robots that have undocked are out of the way, in map.
PLACES = {"/robot1": (-3.6, 0.4), "/robot2": (-3.6, 1.6), "/robot3": (-3.6, -0.9)}


class Operators(Worker):
    """Does something with missions or robots again and again, at whichever gateway answers.

    Args:
        url: Where a gateway is now; called again for each request.
        docks: The names of the docks.

    Attributes:
        queued: The ids of the missions that were accepted.
        answers: How often each answer came.
    """

    def __init__(self, url: Callable[[], str], docks: tuple[str, ...]) -> None:
        super().__init__("operators")
        self._url = url
        self._docks = docks
        self._orders = itertools.count(1)
        self.queued: set[str] = set()
        self.answers: Counter[str] = Counter()

    def ask(self, method: str, path: str, **request: Any) -> httpx2.Response:
        """Send a request until a gateway has answered it."""
        deadline = time.monotonic() + PATIENCE
        while True:
            assert time.monotonic() < deadline, (path, self.answers)
            try:
                with HttpClient(self._url(), timeout=20.0) as http:
                    answer = http.request(method, path, **request)
            except httpx2.HTTPError:
                self.answers["broken off"] += 1
                time.sleep(0.1)
                continue
            code = answer.json().get("code") if answer.content else None
            self.answers[f"{method} /{path.split('/')[1]}: {code or answer.status_code}"] += 1
            # A gateway that has just begun has not found all robots yet.
            if answer.status_code not in (429, 503, 504) and code != "robot_not_found":
                return answer
            time.sleep(0.2)

    def missions(self, *statuses: str) -> list[dict[str, Any]]:
        """Return the missions with some states."""
        answers = [self.ask("GET", "/missions", params={"status": status}).json() for status in statuses]
        return [mission for answer in answers for mission in answer.get("missions", ())]

    def turn(self) -> None:
        """Do something, and wait a little."""
        ways = [self.queue, self.go_on, self._pause, self._end_one, self._stop_robots]
        random.choices(ways, [6, 8, 1, 0.4, 0.6])[0]()
        self.stopping.wait(random.expovariate(1 / 2.0))

    def queue(self) -> None:
        """Queue a mission, unless very many wait."""
        if len(self.missions("queued")) >= 6:
            return
        robot = random.choice([*PLACES, None])
        steps = [step for _ in range(random.randint(1, 3)) for step in self._steps(robot)]
        body: dict[str, Any] = {"steps": steps, "priority": random.choice([20, 50, 80])}
        if random.random() < 0.7:
            body["battery"] = {"below": 0.2, "charge_to": 0.27}
        if robot is None:
            body["group"] = "all"
        at = {} if robot is None else {"robot": robot}
        headers = {"Idempotency-Key": str(uuid.uuid4())}
        answer = self.ask("POST", "/missions", params=at, json=body, headers=headers)
        assert answer.status_code in (200, 201), answer.text
        self.queued.add(answer.json()["mission_id"])

    def _steps(self, robot: str | None) -> list[Step]:
        """Return a step, or two that belong together."""
        kind = random.choices(["work", "dock", "wait", "drive"], [5, 3, 1, 1 if robot else 0])[0]
        if kind == "work":
            goal = {"order": next(self._orders)}
            return [{"action": {"name": "/fibonacci", "goal": goal}, "tries": random.choice([1, 2])}]
        if kind == "wait":
            return [{"wait": {"seconds": random.uniform(0, 5)}}]
        if kind == "dock":
            named = {"dock_id": random.choice(self._docks)} if random.random() < 0.5 else {}
            dock: Step = {"dock": named, "tries": 3, "on_failure": "next", "timeout_s": 180}
            away = [self._drive(robot)] if robot else []
            return [dock, {"undock": {}, "tries": 2, "on_failure": "next"}, *away]
        assert robot is not None
        return [self._drive(robot)]

    @staticmethod
    def _drive(robot: str) -> Step:
        x, y = PLACES[robot]
        pose = {"x": x + random.uniform(-0.3, 0.3), "y": y + random.uniform(-0.3, 0.3)}
        return {"navigate": {"pose": pose}, "on_failure": "next", "timeout_s": 60}

    def go_on(self) -> None:
        """Let all missions go on that are held."""
        for mission in self.missions("held"):
            verb = "skip" if random.random() < 0.05 else "continue"
            self.ask("POST", f"/missions/{mission['mission_id']}/{verb}")

    def _one(self) -> dict[str, Any] | None:
        found = self.missions("running", "queued")
        return random.choice(found) if found else None

    def _pause(self) -> None:
        if (mission := self._one()) is not None:
            self.ask("POST", f"/missions/{mission['mission_id']}/pause")

    def _end_one(self) -> None:
        if (mission := self._one()) is not None:
            self.ask("POST", f"/missions/{mission['mission_id']}/cancel")

    def _stop_robots(self) -> None:
        at = random.choice([{}, *({"robot": robot} for robot in PLACES)])
        self.ask("POST", "/stop", params=at)
        self.stopping.wait(random.uniform(0.2, 3))
        self.ask("DELETE", "/stop", params=at)
