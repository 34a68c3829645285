"""Services, parameters and topics over REST: a real gateway, and a real node that misbehaves."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from websockets.exceptions import InvalidStatus

from dock_gateway.client import AsyncClient, Client, GatewayRefused
from tests.support.domain import ros_domain
from tests.support.gateway import RunningGateway, running_gateway, running_service_node, running_talker
from tests.support.installed import needs
from tests.support.processes import Process
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

LISTS = {
    "allow_services": "/robot1/echo,/robot1/never,/robot1/huge,/robot1/leave,/*/_action/*,/*_parameters*",
    "allow_publish": "/robot1/*,/battery_status,/nobody,/no_one,/mixed,/stop_latched,*/_action/*",
    "allow_parameters": "/robot1/base",
    "server_wait": "0.5",
}
TWIST = "geometry_msgs/msg/Twist"


@pytest.fixture(scope="module")
def domain() -> Iterator[int]:
    with ros_domain() as number:
        yield number


@pytest.fixture(scope="module")
def node(domain: int) -> Iterator[Process]:
    with running_service_node(domain) as process:
        yield process


@pytest.fixture(scope="module")
def open_gateway(domain: int, node: Process) -> Iterator[RunningGateway]:
    """A gateway whose settings allow something."""
    with running_gateway(domain, **LISTS) as gateway:
        wait_for_node(gateway)
        yield gateway


def wait_for_node(gateway: RunningGateway) -> None:
    """Wait until the gateway has found all of the node."""

    def found() -> bool:
        graph = gateway.http.get("/graph").raise_for_status().json()
        services = {service["name"] for service in graph["services"] if service["servers"]}
        heard = {topic["name"] for topic in graph["topics"] if topic["subscribers"]}
        names = ("base/list_parameters", "base/set_parameters_atomically", "echo", "huge", "never")
        return {f"/robot1/{name}" for name in names} <= services and {"/robot1/cmd_vel", "/robot1/chatter"} <= heard

    wait_until(found, "the node")


def answered(gateway: RunningGateway, method: str, path: str, body: object = None, **params: Any) -> Any:
    answer = gateway.http.request(method, path, params=params, **({} if body is None else {"json": body}))
    return answer.status_code, answer.json()


def refusal(gateway: RunningGateway, method: str, path: str, body: object = None, **params: Any) -> tuple[int, str]:
    status, problem = answered(gateway, method, path, body, **params)
    return status, problem["code"]


# ---------------------------------------------------------------------- services


def test_a_service_is_described_and_called(open_gateway: RunningGateway) -> None:
    status, found = answered(open_gateway, "GET", "/services/robot1/echo")
    assert (status, found["type"], found["call"]) == (200, "std_srvs/srv/SetBool", {"allowed": True, "reason": None})
    assert found["request"]["properties"]["data"]["type"] == "boolean"
    assert "triggered service" in found["response"]["properties"]["success"]["description"]
    status, answer = answered(open_gateway, "POST", "/services/robot1/echo", {"data": True})
    assert (status, answer["response"]) == (200, {"success": True, "message": "echoed"})


def test_a_wrong_request_names_the_field_and_a_wrong_name_has_a_hint(open_gateway: RunningGateway) -> None:
    status, problem = answered(open_gateway, "POST", "/services/robot1/echo", {"data": 1, "date": True})
    assert (status, [error["path"] for error in problem["errors"]]) == (422, ["data", "date"])
    status, problem = answered(open_gateway, "POST", "/services/robot1/ecko", {"data": True})
    assert (status, problem["code"]) == (404, "service_not_found")
    assert "did you mean /robot1/echo" in problem["detail"]
    for odd in ("robot1/e%20o", "%2e%2e/x", "ü", "a" * 300, "robot1//echo"):
        assert refusal(open_gateway, "POST", f"/services/{odd}", {})[0] in (404, 422), odd


def test_a_service_that_never_answers_harms_no_other(open_gateway: RunningGateway) -> None:
    assert refusal(open_gateway, "POST", "/services/robot1/never", {}, timeout_s=0.2) == (504, "service_timeout")
    with ThreadPoolExecutor(12) as pool:
        waiting = [
            pool.submit(refusal, open_gateway, "POST", "/services/robot1/never", {}, timeout_s=2) for _ in range(12)
        ]
        status, _ = answered(open_gateway, "POST", "/services/robot1/echo", {"data": True})
        codes = [future.result()[1] for future in waiting]
    assert status == 200
    assert set(codes) == {"service_timeout", "too_many_calls"}


def test_a_server_that_leaves_and_a_response_that_is_too_large_are_said(open_gateway: RunningGateway) -> None:
    assert refusal(open_gateway, "POST", "/services/robot1/huge", {}) == (502, "response_too_large")
    with ThreadPoolExecutor(1) as pool:
        waiting = pool.submit(refusal, open_gateway, "POST", "/services/robot1/leave", {}, timeout_s=60)
        answered(open_gateway, "POST", "/topics/robot1/chatter", {"data": "leave"})
        assert waiting.result() in ((503, "service_gone"), (503, "service_unavailable"), (404, "service_not_found"))


def test_parts_of_actions_and_parameters_are_not_called_whatever_the_settings_say(
    open_gateway: RunningGateway,
) -> None:
    path = "/services/robot1/base"
    assert refusal(open_gateway, "POST", f"{path}/set_parameters", {}) == (403, "use_other_request")
    status, answer = answered(open_gateway, "POST", f"{path}/list_parameters", {})
    assert (status, "speed" in answer["response"]["result"]["names"]) == (200, True)


# ---------------------------------------------------------------------- parameters


def read(gateway: RunningGateway) -> dict[str, Any]:
    status, found = answered(gateway, "GET", "/nodes/robot1/base/parameters")
    assert status == 200, found
    return {parameter["name"]: parameter for parameter in found["parameters"]}


def change(gateway: RunningGateway, values: object, **params: Any) -> Any:
    return answered(gateway, "PATCH", "/nodes/robot1/base/parameters", values, **params)


def test_parameters_have_values_types_and_ranges(open_gateway: RunningGateway) -> None:
    found = read(open_gateway)
    assert found["speed"] == {
        "name": "speed",
        "type": "double",
        "value": 0.5,
        "description": "In m/s",
        "constraints": "",
        "read_only": False,
        "dynamic_typing": False,
        "range": {"minimum": 0.0, "maximum": 1.0, "step": 0.1},
    }
    values = {name: (parameter["type"], parameter["value"]) for name, parameter in found.items()}
    assert values["limit"] == ("integer", str(2**63 - 1))
    assert values["unmeasured"] == ("double", None)
    assert values["raw"] == ("byte array", [0, 255])
    assert values["offset"] == ("double", None)
    assert values["odd.name-with spaces/ü"] == ("boolean", True)
    assert found["fixed"]["read_only"]


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"speed": 1.5}, "speed: expected 0 to 1 in steps of 0.1"),
        ({"speed": 0.55}, "in steps of 0.1"),
        ({"speed": None}, "speed: expected 0 to 1"),
        ({"speed": "fast"}, "speed: expected float64"),
        ({"count": 7}, "count: expected 0 to 10 in steps of 5"),
        ({"limit": 2**63}, "limit: expected int64"),
        ({"raw": [0, 256]}, "raw.1: expected octet"),
        ({"fixed": "other"}, "it is read-only"),
        ({"sped": 1}, "such as speed"),
        ({"free": {}}, "free: expected int64"),
        ({}, "1 to 100 parameters"),
        ([1], "an object with parameters"),
    ],
)
def test_a_wrong_value_is_refused_before_anything_is_sent(
    open_gateway: RunningGateway, values: object, said: str
) -> None:
    status, problem = change(open_gateway, values)
    assert status == 422
    assert said in problem["detail"]


def test_parameters_are_set_all_or_none_or_each_by_itself(open_gateway: RunningGateway) -> None:
    good = {"speed": 0.3, "count": 10, "limit": str(-(2**63)), "raw": "AAE=", "offset": 2, "free": "a text"}
    status, answer = change(open_gateway, good)
    assert (status, {each["name"]: each["value"] for each in answer["parameters"]}) == (
        200,
        {**good, "raw": [0, 1], "offset": 2.0},
    )
    status, problem = change(open_gateway, {"speed": 0.6, "names": ["bad"]})
    assert (status, problem["code"]) == (409, "parameters_refused")
    assert "bad is not a name" in problem["detail"]
    assert read(open_gateway)["speed"]["value"] == 0.3
    status, answer = change(open_gateway, {"speed": 0.6, "names": ["bad"]}, at_once=False)
    results = [(each["name"], each["successful"], each["reason"], each["value"]) for each in answer["parameters"]]
    assert results == [("speed", True, "", 0.6), ("names", False, "bad is not a name", ["a", "b"])]


def test_an_unknown_node_has_a_hint(open_gateway: RunningGateway) -> None:
    status, problem = answered(open_gateway, "GET", "/nodes/robot1/bass/parameters")
    assert (status, problem["code"]) == (404, "node_not_found")
    assert "did you mean /robot1/base" in problem["detail"]


# ---------------------------------------------------------------------- topics


def test_a_message_is_published_as_it_is_typed_on_the_graph(open_gateway: RunningGateway, node: Process) -> None:
    status, found = answered(open_gateway, "GET", "/topics/robot1/chatter")
    assert (status, found["type"], found["publish"]["allowed"]) == (200, "std_msgs/msg/String", True)
    status, answer = answered(open_gateway, "POST", "/topics/robot1/chatter", {"data": "hello"})
    assert (status, answer["subscribers"], answer["message"]) == (200, 1, {"data": "hello"})
    node.wait_for("heard hello")
    assert refusal(open_gateway, "POST", "/topics/robot1/chatter", {"dat": 1}) == (422, "invalid_field")
    assert refusal(open_gateway, "POST", "/topics/robot1/chatter", {}, type=TWIST) == (422, "invalid_field")


def test_a_topic_where_no_one_is_needs_a_type(open_gateway: RunningGateway) -> None:
    assert refusal(open_gateway, "POST", "/topics/nobody", {}) == (404, "topic_not_found")
    status, answer = answered(open_gateway, "POST", "/topics/nobody", {"data": 1}, type="std_msgs/msg/Int64")
    assert (status, answer["subscribers"]) == (200, 0)
    unknown = refusal(open_gateway, "POST", "/topics/no_one", {}, type="no_msgs/msg/No")
    assert unknown == (501, "interface_not_installed")


def test_a_topic_with_two_types_needs_one_of_them(open_gateway: RunningGateway, domain: int) -> None:
    strings, flags = (("--topic", f"/mixed:std_msgs/msg/{kind}:1") for kind in ("String", "Bool"))
    with running_talker(domain, *strings), running_talker(domain, *flags):
        wait_until(lambda: len(answered(open_gateway, "GET", "/graph/topics/mixed")[1].get("types", ())) == 2, "both")
        status, problem = answered(open_gateway, "POST", "/topics/mixed", {"data": True})
        assert (status, problem["errors"][0]["path"]) == (422, "type")
        status, answer = answered(open_gateway, "POST", "/topics/mixed", {"data": "x"}, type="std_msgs/msg/String")
        assert (status, answer["type"]) == (200, "std_msgs/msg/String")
        # It reads the first type, of which one participant cannot be as well.
        with pytest.raises(InvalidStatus, match="409"), open_gateway.echo("/mixed"):
            pass


# ---------------------------------------------------------------------- clients


async def test_the_python_clients_do_the_same(open_gateway: RunningGateway, node: Process) -> None:
    with Client(open_gateway.url) as client:
        assert client.call_service("/robot1/echo", {"data": True}) == {"success": True, "message": "echoed"}
        assert client.publish("/robot1/chatter", {"data": "from Python"}) == 1
        node.wait_for("heard from Python")
        assert client.set_parameters("/robot1/base", {"speed": 0.4}) == {"speed": 0.4}
        with pytest.raises(GatewayRefused, match="--allow-publish '/elsewhere'"):
            client.publish("/elsewhere", {})
    async with AsyncClient(open_gateway.url) as aio:
        assert (await aio.call_service("robot1/echo"))["message"] == "echoed"
        assert await aio.publish("robot1/chatter", {"data": "again"}) == 1
        await aio.set_parameters("/robot1/base", {"speed": 0.2})
        assert (await aio.parameters("/robot1/base"))["speed"] == 0.2


# ---------------------------------------------------------------------- what moves robots


def test_nothing_reaches_a_stopped_robot(open_gateway: RunningGateway, node: Process) -> None:
    drive, echo = "/topics/robot1/cmd_vel", "/services/robot1/echo"
    assert answered(open_gateway, "POST", drive, {"linear": {"x": 0.1}})[0] == 200
    node.wait_for("driven at 0.1")
    open_gateway.http.post("/stop").raise_for_status()
    status, problem = answered(open_gateway, "POST", drive, {"linear": {"x": 0.7}})
    assert (status, problem["code"]) == (409, "stop_latched")
    assert "DELETE /stop" in problem["detail"]
    assert refusal(open_gateway, "POST", echo, {"data": True}) == (409, "stop_latched")
    assert answered(open_gateway, "POST", "/services/robot1/base/get_parameters", {"names": []})[0] == 200
    assert answered(open_gateway, "POST", "/topics/battery_status", {"percentage": 0.5})[0] == 200
    open_gateway.http.delete("/stop").raise_for_status()
    assert answered(open_gateway, "POST", drive, {"linear": {"x": 0.2}})[0] == 200
    node.wait_for("driven at 0.2")
    assert "driven at 0.7" not in node.output


def test_stops_and_actions_cannot_be_faked_whatever_the_settings_say(open_gateway: RunningGateway) -> None:
    assert refusal(open_gateway, "POST", "/topics/stop_latched", {"data": False}) == (403, "use_other_request")
    assert refusal(open_gateway, "POST", "/topics/robot1/stop_latched", {}) == (403, "use_other_request")
    path = "/topics/connect_to_charging_dock/_action/status"
    assert refusal(open_gateway, "POST", path, {}) == (403, "use_other_request")


@needs("audit_log")
def test_by_default_there_is_only_reading(domain: int, node: Process) -> None:
    with running_gateway(domain) as gateway:
        wait_for_node(gateway)
        for method, path, option in (
            ("POST", "/services/robot1/echo", "--allow-services '/robot1/echo'"),
            ("POST", "/topics/robot1/cmd_vel", "--allow-publish '/robot1/cmd_vel'"),
            ("PATCH", "/nodes/robot1/base/parameters", "--allow-parameters '/robot1/base'"),
        ):
            status, problem = answered(gateway, method, path, {"data": True})
            assert (status, problem["code"]) == (403, "not_allowed"), path
            assert option in problem["detail"]
            assert problem["settings"]
        assert answered(gateway, "GET", "/services/robot1/echo")[1]["call"]["allowed"] is False
        assert answered(gateway, "POST", "/services/robot1/base/list_parameters", {})[0] == 200
        assert read(gateway)["speed"]["type"] == "double"
        records = answered(gateway, "GET", "/audit")[1]["records"]
        assert ("call_service", "/robot1/echo", "/robot1") in {
            (entry["what"], entry["subject"], entry["robot"]) for entry in records
        }
