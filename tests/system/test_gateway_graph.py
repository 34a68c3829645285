"""The ROS graph as the API shows it: real gateway, real nodes."""

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import httpx2
import pytest

from tests.support.gateway import RunningGateway, running_gateway, running_program, running_talker
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

NODES = 60
Graph = dict[str, list[dict[str, Any]]]


def wait_for_graph(gateway: RunningGateway, matches: Callable[[Graph], bool]) -> Graph:
    def found() -> Graph | None:
        graph: Graph = gateway.http.get("/graph").raise_for_status().json()
        return graph if matches(graph) else None

    return wait_until(found, "the graph")


def find(entries: list[dict[str, Any]], name: str) -> dict[str, Any]:
    (entry,) = [entry for entry in entries if entry["name"] == name]
    return entry


def names(entries: list[dict[str, Any]]) -> set[str]:
    return {entry["name"] for entry in entries}


def test_an_action_is_one_thing_and_its_server_and_client_are_named(
    gateway: RunningGateway, shared_domain: int
) -> None:
    with running_program(shared_domain, "fibonacci_action_server"):
        graph = wait_for_graph(
            gateway, lambda graph: any(a["name"] == "/fibonacci" and a["clients"] for a in graph["actions"])
        )
    fibonacci = find(graph["actions"], "/fibonacci")
    assert fibonacci["types"] == ["action_tutorials_interfaces/action/Fibonacci"]
    assert fibonacci["servers"] == ["/fibonacci_action_server"]
    assert fibonacci["clients"] == ["/dock_gateway"]
    assert "/fibonacci" in find(graph["nodes"], "/fibonacci_action_server")["action_servers"]
    assert not [name for name in names(graph["topics"]) | names(graph["services"]) if "/_action/" in name]
    assert find(graph["topics"], "/rosout")["hidden"]
    assert find(graph["services"], "/fibonacci_action_server/get_parameters")["hidden"]
    assert not find(graph["topics"], "/battery_status")["hidden"]


def test_sixty_nodes_with_their_topics_and_qualities(gateway: RunningGateway, shared_domain: int) -> None:
    with running_talker(shared_domain, "--nodes", str(NODES)):
        wanted = {f"/talker{number}/talker" for number in range(NODES)}

        def is_complete(graph: dict[str, Any]) -> bool:
            if not (wanted <= names(graph["nodes"]) and "/talker7/battery_status" in names(graph["topics"])):
                return False
            topic = find(graph["topics"], "/talker7/battery_status")
            ends = (topic["publishers"], topic["subscribers"])
            return all(find(graph["nodes"], name)["services"] for name in wanted) and all(
                "/talker7/talker" in {entry["node"] for entry in end} for end in ends
            )

        graph = wait_for_graph(gateway, is_complete)
        with ThreadPoolExecutor(8) as pool:
            answers = list(pool.map(lambda _: gateway.http.get("/graph").status_code, range(40)))
        assert answers == [200] * 40
        topic = find(graph["topics"], "/talker7/battery_status")
        assert topic["types"] == ["sensor_msgs/msg/BatteryState"]
        (publisher,) = [entry for entry in topic["publishers"] if entry["node"] == "/talker7/talker"]
        (subscriber,) = [entry for entry in topic["subscribers"] if entry["node"] == "/talker7/talker"]
        assert (publisher["qos"]["reliability"], subscriber["qos"]["reliability"]) == ("best_effort", "reliable")
        assert (publisher["qos"]["durability"], publisher["qos"]["deadline_s"]) == ("volatile", None)

        alone = gateway.http.get("/graph/topics/talker7/battery_status").json()
        assert {entry["node"] for entry in alone["publishers"]} >= {"/talker7/talker"}
        assert alone.keys() == topic.keys()
    wait_for_graph(gateway, lambda graph: not wanted & names(graph["nodes"]))


def test_nodes_of_the_same_name_are_counted(gateway: RunningGateway, shared_domain: int) -> None:
    with running_talker(shared_domain), running_talker(shared_domain):
        graph = wait_for_graph(
            gateway, lambda graph: any(n["name"] == "/talker0/talker" and n["count"] == 2 for n in graph["nodes"])
        )
        talkers = [entry["node"] for entry in find(graph["topics"], "/talker0/battery_status")["publishers"]]
        assert talkers.count("/talker0/talker") == 2


def test_what_is_known_is_not_sent_again(domain: int) -> None:
    with running_gateway(domain) as gateway:
        wait_for_graph(gateway, lambda graph: names(graph["nodes"]) == {"/dock_gateway"})
        tag = ""

        def same() -> httpx2.Response | None:
            """Ports of robots that left are closed a little later."""
            nonlocal tag
            tag = gateway.http.get("/graph").headers["etag"]
            time.sleep(1.1)
            answer = gateway.http.get("/graph", headers={"If-None-Match": tag})
            return answer if answer.status_code == 304 else None

        answer = wait_until(same, "a graph that does not change")
        assert (answer.content, answer.headers["etag"]) == (b"", tag)
        with running_talker(domain):
            wait_for_graph(gateway, lambda graph: "/talker0/talker" in names(graph["nodes"]))
            changed = gateway.http.get("/graph", headers={"If-None-Match": tag})
            assert (changed.status_code, changed.headers["etag"] != tag) == (200, True)


def test_topics_that_are_not_there(gateway: RunningGateway) -> None:
    for path in ("nope", "a//b", "battery_status%00x", "%7Bnode%7D", "x" * 300):
        response = gateway.http.get(f"/graph/topics/{path}")
        assert (response.status_code, response.json()["code"]) == (404, "topic_not_found"), path
    assert gateway.http.get("/graph?robot=/robot1").status_code == 422
