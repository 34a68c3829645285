"""A stop that cannot be understood as a whole is carried out, by the defaults. What stops is a fake."""

from types import SimpleNamespace
from typing import Any

import pytest

from dock_gateway.api.stop import stop_robot
from dock_gateway.errors import MalformedRequest
from dock_gateway.stop import StopReport


class FakeStopper:
    def __init__(self) -> None:
        self.stops: list[tuple[str | None, dict[str, Any]]] = []

    async def stop(self, robot: str | None, **how: Any) -> StopReport:
        self.stops.append((robot, how))
        return StopReport(canceling=["a"])


@pytest.mark.parametrize(
    ("value", "how", "wrong"),
    [
        ({}, {"latch": True, "by": None}, None),
        ({"latch": False, "by": " Ada "}, {"latch": False, "by": "Ada"}, None),
        ({"by": None}, {"latch": True, "by": None}, None),
        ({"latch": "false"}, {}, "latch"),
        ({"latch": False, "by": "a" * 101}, {}, "by"),
        ({"latch": False, "lock": 1}, {}, "lock"),
        ([], {}, ""),
        (None, {}, ""),
    ],
)
async def test_how_it_stops(value: object, how: dict[str, Any], wrong: str | None) -> None:
    stopper = FakeStopper()
    gateway: Any = SimpleNamespace(stopper=stopper)
    report = await stop_robot(gateway, "/robot1", value, wait=2.0)
    assert stopper.stops == [("/robot1", {**how, "wait": 2.0})]
    assert report["canceling"] == ["a"]
    warning = report["warning"]
    assert (warning and warning["errors"][0]["path"]) == wrong


async def test_what_was_wrong_before_is_told() -> None:
    gateway: Any = SimpleNamespace(stopper=FakeStopper())
    report = await stop_robot(gateway, None, {}, problem=MalformedRequest("the body was cut off"))
    assert (report["warning"]["status"], report["warning"]["code"]) == (400, "malformed_json")
