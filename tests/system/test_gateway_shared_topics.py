"""Topics of all robots, such as `/rosout`, are read only by who may see every robot, at whichever door."""

from collections.abc import Iterator
from io import BytesIO

import orjson
import pytest
from mcap.reader import make_reader
from websockets.exceptions import InvalidStatus

from tests.support.access import Site, bearer
from tests.support.clients import connect
from tests.support.doors import doors
from tests.support.gateway import RunningGateway, running_program
from tests.support.installed import needs
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

SHARED = ("/rosout", "/parameter_events", "/diagnostics", "/tf")
OWN = "/battery_status"


@pytest.fixture(scope="module")
def everyone(site: Site) -> dict[str, str]:
    return bearer(site.token("everyone", "operator"))


@pytest.fixture(scope="module")
def gateway(shared_domain: int, site: Site, root: dict[str, str], everyone: dict[str, str]) -> Iterator[RunningGateway]:
    with (
        running_program(shared_domain, "dock_simulator"),
        running_program(shared_domain, "dock_simulator", "-r", "__ns:=/robot1"),
        site.gateway(shared_domain, allow_publish="/*", recordings="all") as gateway,
    ):
        for topic in (*SHARED, OWN):
            path = f"/graph/topics{topic}"
            wait_until(lambda path=path: gateway.http.get(path, headers=everyone).json().get("publishers"), topic)
        yield gateway


@pytest.mark.parametrize("topic", SHARED)
def test_it_is_not_read(gateway: RunningGateway, topic: str, root: dict[str, str], everyone: dict[str, str]) -> None:
    for path in (f"/topics{topic}", f"/graph/topics{topic}"):
        assert gateway.http.get(path, headers=everyone).status_code == 200
        assert gateway.http.get(path, headers=root).json()["code"] == "not_allowed"
    assert gateway.http.post(f"/topics{topic}", json={}, headers=root).json()["code"] == "not_allowed"

    url = f"{gateway.url.replace('http', 'ws')}/ws/topics?topic={topic}"
    with pytest.raises(InvalidStatus) as refused:
        connect(url, additional_headers=root)
    assert orjson.loads(refused.value.response.body or b"")["code"] == "not_allowed"

    for door in doors():
        if door.reads is not None:
            assert not door.reads(gateway, root, topic), door.name
            assert door.reads(gateway, root, OWN), door.name


def require_own(names: set[str]) -> None:
    assert OWN in names
    assert not names & set(SHARED)
    assert not any(name.startswith("/robot1/") for name in names)


def test_it_is_in_no_list(gateway: RunningGateway, root: dict[str, str], everyone: dict[str, str]) -> None:
    def listed(headers: dict[str, str]) -> set[str]:
        graph = gateway.http.get("/graph", headers=headers).raise_for_status().json()
        return {topic["name"] for topic in graph["topics"]}

    assert set(SHARED) <= listed(everyone)
    require_own(listed(root))
    for door in doors():
        if door.topics is not None:
            topics = door.topics(gateway, root, OWN)
            assert OWN in topics, door.name
            assert not topics & set(SHARED), door.name


@needs("recordings")
def test_it_is_in_no_recording(gateway: RunningGateway, root: dict[str, str], everyone: dict[str, str]) -> None:
    def recorded(headers: dict[str, str]) -> set[str]:
        file = gateway.http.get("/recording.mcap?robot=/", headers=headers).raise_for_status().content
        summary = make_reader(BytesIO(file)).get_summary()
        assert summary is not None
        return {channel.topic for channel in summary.channels.values()}

    wait_until(lambda: {"/tf", "/diagnostics", OWN} <= recorded(everyone), "what is recorded")
    require_own(recorded(root))
