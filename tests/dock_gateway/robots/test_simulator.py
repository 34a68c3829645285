"""Which simulators are known: those of robots, until the robot is gone. tests/system has a real one."""

from collections.abc import AsyncIterator
from typing import Any

import orjson
import pytest

from dock_gateway.core.fanout import Fanout
from dock_gateway.robots.simulator import Simulators
from tests.support.waiting import until

REPORT = {"docked": "false", "real_time_factor": "1.0"}


@pytest.fixture
def robots() -> set[str]:
    return {"/", "/robot1"}


@pytest.fixture
async def simulators(robots: Any, request: pytest.FixtureRequest) -> AsyncIterator[Simulators]:
    simulators = Simulators(Fanout(queue_limit=10), robots, **getattr(request, "param", {}))
    yield simulators
    await simulators.close()


async def test_reports_that_name_no_robot_are_not_kept(simulators: Simulators) -> None:
    for number in range(100):
        simulators.on_report(f"/fleet/robot{number}", REPORT)
    assert simulators.document("/fleet/robot1") is None
    simulators.on_report("/robot1", REPORT)
    known = simulators.document("/robot1")
    assert known is not None
    assert (known["available"], known["docked"], known["real_time_factor"]) == (True, False, 1.0)


async def test_the_simulator_of_a_robot_that_is_gone_is_forgotten(simulators: Simulators, robots: set[str]) -> None:
    simulators.on_report("/robot1", REPORT)
    robots.remove("/robot1")
    await until(lambda: simulators.document("/robot1") is None)
    assert "/robot1" not in simulators


@pytest.mark.parametrize("simulators", [{"gone_after": 0.0}], indirect=True)
async def test_one_that_is_silent_stays_known_but_is_not_available(simulators: Simulators) -> None:
    simulators.on_report("/robot1", REPORT)
    await until(lambda: simulators.find("/robot1") is None)
    known = simulators.document("/robot1")
    assert known is not None
    assert not known["available"]


@pytest.mark.parametrize(
    ("text", "places"),
    [
        ('{"shelf": [-4.0, -2.6, -1.57]}', [{"name": "shelf", "x": -4.0, "y": -2.6, "theta": -1.57}]),
        ('{"a": [1, 2, 3], "b": [1, 2], "c": "d", "": [0, 0, 0], "e": [true, 0, 0], "f": [NaN, 0, 0]}', []),
        ('{"a": [1, 2, 3], "b": [1, 2], "c": "d", "": [0, 0, 0], "e": [true, 0, 0]}', ["a"]),
        ("[1, 2]", []),
        ("{", []),
        (None, []),
    ],
)
async def test_places_are_taken_from_a_report(simulators: Simulators, text: str | None, places: list[Any]) -> None:
    simulators.on_report("/robot1", REPORT if text is None else {**REPORT, "places": text, "too_slow": "true"})
    known = simulators.document("/robot1")
    assert known is not None
    assert known["too_slow"] is (None if text is None else True)
    names = [place["name"] for place in known["places"]]
    assert known["places"] == places or names == places


async def test_there_are_only_so_many_places(simulators: Simulators) -> None:
    text = orjson.dumps({str(number): [0, 0, 0] for number in range(1000)}).decode()
    simulators.on_report("/robot1", {**REPORT, "places": text})
    known = simulators.document("/robot1")
    assert known is not None
    assert len(known["places"]) == 100
