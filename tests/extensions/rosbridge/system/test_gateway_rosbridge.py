"""`/rosbridge`: what clients of rosbridge send and get, on a real gateway with real ROS nodes."""

import base64
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import orjson
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from tests.extensions.rosbridge.door import Client, client_of
from tests.support.access import Site, bearer
from tests.support.clients import open_websocket
from tests.support.gateway import (
    RunningGateway,
    running_gateway_with_talker,
)
from tests.support.installed import needs
from tests.support.processes import free_port
from tests.support.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.ros

# More steps than a test takes; the server accepts no more.
LONG = 45
# What clients may reach past goals and the latch.
ALLOWED = {"allow_publish": "/chatter,/points,/cmd_vel", "allow_parameters": "/talker0/talker"}
TWIST = "geometry_msgs/msg/Twist"
SCAN = "sensor_msgs/msg/LaserScan"


@pytest.fixture(scope="module")
def gateway(shared_domain: int) -> Iterator[RunningGateway]:
    with running_gateway_with_talker(shared_domain, **ALLOWED) as gateway:
        yield gateway


@pytest.fixture
def client(gateway: RunningGateway) -> Iterator[Client]:
    with client_of(gateway) as client:
        yield client


def test_a_goal_with_feedback_and_a_result(gateway: RunningGateway, client: Client) -> None:
    client.goal(4, "g1", feedback=True)
    result = client.until("action_result")
    assert result == {
        "op": "action_result",
        "id": "g1",
        "action": "/fibonacci",
        "values": {"sequence": [0, 1, 1, 2, 3]},
        "status": 4,
        "result": True,
    }
    first, *_ = (message for message in client.seen if message["op"] == "action_feedback")
    assert first == {
        "op": "action_feedback",
        "id": "g1",
        "action": "/fibonacci",
        "values": {"partial_sequence": [0, 1, 1]},
    }
    client.goal(0, "in order", args=[2])
    assert client.until("action_result", id="in order")["values"] == {"sequence": [0, 1, 1]}
    (goal, *_) = gateway.http.get("/actions/fibonacci/goals").json()["goals"]
    assert (goal["status"], goal["origin"]) == ("succeeded", "gateway")


def test_a_goal_is_canceled_by_its_id_even_while_it_is_sent(client: Client) -> None:
    client.goal(LONG, "g1")
    client.send("cancel_action_goal", id="g1", action="/fibonacci")
    result = client.until("action_result", id="g1")
    assert (result["status"], result["result"]) == (5, True)
    assert not [message for message in client.seen if message["op"] == "action_feedback"]
    client.send("cancel_action_goal", id="g1", action="/fibonacci")
    client.error("cancel_action_goal: ")


def test_goals_that_are_not_accepted(client: Client) -> None:
    for identity, fields in {
        "order": {"args": {"order": "ten"}},
        "unknown": {"action": "/nowhere"},
        "rejected": {"args": {"order": -1}},
    }.items():
        client.goal(3, identity, **fields)
        result = client.until("action_result", id=identity)
        assert (result["status"], result["result"]) == (0, False)
        assert isinstance(result["values"], str)


def test_a_goal_survives_its_client_and_a_stop_ends_it_for_another(gateway: RunningGateway, client: Client) -> None:
    with client_of(gateway) as other:
        other.goal(LONG, "g1", feedback=True)
        other.until("action_feedback")
    client.goal(LONG, "mine", feedback=True)
    client.until("action_feedback")
    running = gateway.http.get("/actions/fibonacci/goals", params={"status": "executing"}).json()["goals"]
    assert len(running) == 2
    client.call("/dock_gateway/stop", by="a client")
    assert next(each for each in client.seen[::-1] if each["op"] == "service_response")["values"]["stop"]["latched"]
    result = client.until("action_result", id="mine") if not ended(client, "mine") else ended(client, "mine")[0]
    assert result["status"] == 5
    client.send("call_service", service="/dock_gateway/release_stop", args=["/robot1"], id="list")
    assert client.until("service_response", id="list")["result"] is False
    client.goal(3, "refused")
    assert "stop" in client.until("action_result", id="refused")["values"]
    client.call("/dock_gateway/release_stop")
    for goal in running:
        gateway.wait_for_goal(goal["goal_id"], "canceled")


def ended(client: Client, identity: str) -> list[dict[str, Any]]:
    return [message for message in client.seen if message["op"] == "action_result" and message["id"] == identity]


def test_topics_in_json_and_in_cbor(gateway: RunningGateway, client: Client) -> None:
    client.send("subscribe", topic="/talker0/scan", type="sensor_msgs/LaserScan", id="s1")
    message = client.until("publish", topic="/talker0/scan")["msg"]
    assert message["header"] == {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    assert message["ranges"] == [float(number) for number in range(720)]
    client.send("unsubscribe", topic="/talker0/scan", id="s1")
    wait_until(lambda: not gateway.http.get("/graph/topics/talker0/scan").json()["subscribers"], "it leaves")
    with client_of(gateway) as other:
        other.send("subscribe", topic="/talker0/scan", compression="cbor")
        packed = other.connection.recv(PATIENCE)
        assert isinstance(packed, bytes)
        assert b"cmsg" in packed
        assert bytes.fromhex("d855590b40") in packed  # 2,880 bytes of float32, little-endian


def test_topics_as_images_as_raw_bytes_and_in_pieces(client: Client) -> None:
    client.send("subscribe", topic="/talker0/scan", compression="png")
    assert base64.b64decode(client.until("png")["data"]).startswith(b"\x89PNG")
    client.send("unsubscribe", topic="/talker0/scan")
    client.send("subscribe", topic="/talker0/scan", fragment_size=1000)
    pieces = [client.until("fragment", num=0)]
    while len(pieces) < pieces[0]["total"]:
        pieces.append(client.until("fragment", id=pieces[0]["id"], num=len(pieces)))
    assert orjson.loads("".join(piece["data"] for piece in pieces))["msg"]["ranges"][5] == 5.0
    client.send("unsubscribe", topic="/talker0/scan")
    client.call("/rosapi/get_time")
    client.send("subscribe", topic="/talker0/scan", compression="cbor-raw")
    packed = client.connection.recv(PATIENCE)
    assert isinstance(packed, bytes)
    assert b"dsecs" in packed
    assert b"ebytes" in packed
    assert b"\x00\x01\x00\x00" in packed  # how CDR begins


def test_an_operation_in_pieces(client: Client) -> None:
    text = orjson.dumps({"op": "call_service", "service": "/rosapi/get_ros_version", "id": "x"}).decode()
    for number in (1, 0):
        client.send("fragment", id="f", num=number, total=2, data=text[20 * number :][: 20 if number == 0 else None])
    assert client.until("service_response", id="x")["values"]["version"] == 2
    client.send("fragment", id="f", num=2, total=2, data="")
    client.error("num")
    client.send("fragment", id="f1", num=0, total=3, data="x" * 999_000)
    client.send("fragment", id="f1", num=1, total=3, data="x" * 1001)
    client.error("exceed")
    for number in range(20):  # old incomplete ones make room
        client.send("fragment", id=f"f{number}", num=0, total=2, data="x" * 100_000)
    for number in (0, 1):
        client.send("fragment", id="g", num=number, total=2, data=text[20 * number :][: 20 if number == 0 else None])
    assert client.until("service_response", id="x")["values"]["version"] == 2


def test_the_goals_of_a_client_that_wants_it_end_with_its_connection(gateway: RunningGateway) -> None:
    with client_of(gateway, "?cancel_on_disconnect=true") as other:
        other.goal(LONG, "g1", feedback=True)
        other.until("action_feedback")
        (goal,) = gateway.http.get("/actions/fibonacci/goals", params={"status": "executing"}).json()["goals"]
    gateway.wait_for_goal(goal["goal_id"], "canceled")


def test_a_port_for_rosbridge_tokens_and_tickets(shared_domain: int, tmp_path: Path) -> None:
    site, port = Site(tmp_path), free_port()
    token = site.token("page", "viewer", "--robot", "/robot1")
    with site.gateway(shared_domain, rosbridge_port=str(port)) as guarded:
        with pytest.raises(InvalidStatus) as refused, client_of(guarded):
            pass
        assert refused.value.response.status_code == 401
        ticket = guarded.http.post("/session/ticket", headers=bearer(token)).json()["ticket"]
        with (
            open_websocket(f"ws://127.0.0.1:{port}", additional_headers=bearer(token)) as connection,
            client_of(guarded, f"?ticket={ticket}") as other,
        ):
            client = Client(connection)
            assert "/talker0/scan" not in client.call("/rosapi/topics")["topics"]
            client.send("subscribe", topic="/talker0/scan")
            client.error("the topic /talker0/scan")
            client.send("subscribe", topic="/talker0/scan", name="robot1/scan")  # what counts is the topic
            client.error("the topic /talker0/scan")
            client.goal(3, "g1")
            assert "needs the role" in client.until("action_result")["values"]
            assert other.call("/rosapi/get_ros_version")["version"] == 2


def test_a_latched_topic_for_everyone_who_comes_and_one_that_nobody_has(
    gateway: RunningGateway, client: Client
) -> None:
    client.send("subscribe", topic="/talker0/latched")
    assert client.until("publish")["msg"] == {"data": ""}
    with client_of(gateway) as other:
        other.send("subscribe", topic="talker0/latched")
        assert other.until("publish")["msg"] == {"data": ""}
        other.send("subscribe", topic="/later")
        other.error("no node has this topic yet")
        other.send("subscribe", topic="/talker0/latched", type="std_msgs/Bool", id="b")
        other.send("subscribe", topic="/later", type="nothing_msgs/msg/Nothing")
        other.error("not installed")
        other.send("set_level", level="info")
        other.send("subscribe", topic="/later", type="std_msgs/msg/String")
        other.until("status", level="info", msg="subscribed to /later")


def test_rosapi(client: Client) -> None:
    topics = client.call("/rosapi/topics")
    assert dict(zip(topics["topics"], topics["types"], strict=True))["/talker0/scan"] == SCAN
    assert "/rosout" in topics["topics"]
    assert client.call("rosapi/topics_for_type", type="sensor_msgs/LaserScan") == {"topics": ["/talker0/scan"]}
    assert client.call("/rosapi/topic_type", topic="/talker0/scan") == {"type": SCAN}
    assert client.call("/rosapi/publishers", topic="/talker0/scan") == {"publishers": ["/talker0/talker"]}
    assert "/fibonacci" in client.call("/rosapi/action_servers")["action_servers"]
    assert "/talker0/talker" in client.call("/rosapi/nodes")["nodes"]
    service = "/talker0/talker/get_parameters"
    assert service in client.call("/rosapi/services")["services"]
    assert client.call("/rosapi/service_type", service=service) == {"type": "rcl_interfaces/srv/GetParameters"}
    assert client.call("/rosapi/service_node", service=service) == {"node": "/talker0/talker"}
    assert "/talker0/scan" in client.call("/rosapi/node_details", node="/talker0/talker")["publishing"]
    (definition, *_) = client.call("/rosapi/message_details", type="geometry_msgs/Twist")["typedefs"]
    assert definition["fieldnames"] == ["linear", "angular"]
    assert client.call("/rosapi/get_time")["time"]["sec"] > 1_700_000_000
    assert client.call("/rosapi/get_ros_version")["version"] == 2
    for service in ("/rosapi/nothing", "/rosapi/topic_type"):
        client.send("call_service", service=service, id="x")
        answer = client.until("service_response", id="x")
        assert (answer["result"], type(answer["values"])) == (False, str)


def test_messages_are_published_where_that_is_allowed(client: Client) -> None:
    client.send("publish", topic="/other", msg={"data": "a"}, id="p")
    assert "--allow-publish '/other'" in client.error("publish: ")
    client.send("advertise", topic="/other", type="std_msgs/String")
    client.error("advertise: ")
    client.send("publish", topic="/chatter", msg={"data": "a"})
    client.error("no topic /chatter")
    client.send("subscribe", topic="/chatter", type="std_msgs/String")
    client.send("advertise", topic="/chatter", type="std_msgs/String")
    client.send("publish", topic="/chatter", msg={"data": "a"})
    assert client.until("publish", topic="/chatter")["msg"] == {"data": "a"}
    client.send("publish", topic="/chatter", msg={"data": 7})
    client.error("data: expected a string")
    client.send("unadvertise", topic="/chatter")

    client.send("subscribe", topic="/points", type="geometry_msgs/PointStamped")
    client.send("advertise", topic="/points", type="geometry_msgs/PointStamped")
    client.send("publish", topic="/points", msg={"point": {"x": 1}})
    message = client.until("publish", topic="/points")["msg"]
    assert message["point"] == {"x": 1.0, "y": 0.0, "z": 0.0}
    assert message["header"]["stamp"]["sec"] > 1_700_000_000


@needs("audit_log")
def test_nothing_is_published_on_the_velocity_of_a_stopped_robot(gateway: RunningGateway, client: Client) -> None:
    client.send("subscribe", topic="/cmd_vel", type=TWIST)
    client.send("advertise", topic="/cmd_vel", type=TWIST)
    client.send("publish", topic="/cmd_vel", msg={"linear": {"x": 0.1}})
    client.until("publish", topic="/cmd_vel", msg=twist(0.1))
    assert gateway.http.post("/stop").status_code == 200
    client.send("publish", topic="/cmd_vel", msg={"linear": {"x": 0.2}}, id="p")
    assert client.until("status", id="p")["level"] == "error"
    assert gateway.http.delete("/stop").status_code == 200
    client.send("publish", topic="/cmd_vel", msg={"linear": {"x": 0.3}})
    client.until("publish", topic="/cmd_vel", msg=twist(0.3))
    assert not [message for message in client.seen if message.get("msg") == twist(0.2)]
    entries = gateway.http.get("/audit", params={"what": "advertise"}).json()["records"]
    assert "/cmd_vel" in {entry["subject"] for entry in entries}


def twist(speed: float) -> dict[str, Any]:
    zero = {"x": 0.0, "y": 0.0, "z": 0.0}
    return {"linear": {**zero, "x": speed}, "angular": zero}


@needs("audit_log")
def test_services_and_parameters(gateway: RunningGateway, client: Client) -> None:
    service = "/talker0/talker/get_parameters"
    assert client.call(service, names=["use_sim_time"])["values"][0]["bool_value"] is False
    client.send("call_service", service=service, args=[["use_sim_time"]], id="list")
    assert client.until("service_response", id="list")["values"]["values"][0]["type"] == 1
    name = "/talker0/talker:use_sim_time"
    assert client.call("/rosapi/get_param", name=name)["value"] == "false"
    assert client.call("/rosapi/get_param", name="/talker0/talker:nothing", default_value="7")["value"] == "7"
    assert client.call("/rosapi/has_param", name=name) == {"exists": True}
    assert name in client.call("/rosapi/get_param_names")["names"]
    client.call("/rosapi/set_param", name=name, value="false")
    of_parameters = {"what": "set_param"}
    (entry,) = wait_until(lambda: gateway.http.get("/audit", params=of_parameters).json()["records"], "the audit log")
    assert entry["subject"] == "/talker0/talker use_sim_time"
    for service, args, reason in (
        (
            "/rosapi/set_param",
            {"name": "/fibonacci_action_server:use_sim_time", "value": "false"},
            "--allow-parameters",
        ),
        ("/rosapi/set_param", {"name": name, "value": "{"}, "not JSON"),
        ("/rosapi/get_param", {"name": "use_sim_time"}, "a node and a parameter"),
        ("/fibonacci/_action/cancel_goal", {}, "action"),
        ("/talker0/talker/set_parameters", {}, "parameters"),
        ("/nobody", {}, "no service /nobody"),
    ):
        client.send("call_service", service=service, args=args, id="x")
        answer = client.until("service_response", id="x")
        assert answer["result"] is False
        assert reason in answer["values"]


def test_bad_input_is_answered_and_nothing_is_lost(gateway: RunningGateway, client: Client) -> None:
    client.goal(LONG, "g1", feedback=True)
    client.until("action_feedback")
    with client_of(gateway) as other:
        for text, expected in (
            ("{", "not JSON"),
            (b"\x00\xff", "not JSON"),
            ("[" * 5000, "not JSON"),
            ("[]", "an object with op"),
            ("{}", "op: expected"),
            ('{"op": 7}', "op: expected"),
            ('{"op": "nonsense", "id": "a"}', "unknown operation 'nonsense'"),
            ('{"op": "subscribe"}', "topic: expected"),
            ('{"op": "subscribe", "topic": 7}', "topic: expected"),
            ('{"op": "subscribe", "topic": "/a//{node}", "type": "std_msgs/String"}', "topic: expected a name"),
            ('{"op": "subscribe", "topic": "/rosout", "throttle_rate": -1}', "throttle_rate: expected"),
            ('{"op": "subscribe", "topic": "/rosout", "id": {}}', "id: expected"),
            ('{"op": "call_service"}', "service: expected"),
            ('{"op": "cancel_action_goal", "id": "g1"}', "id: expected"),
            ('{"op": "advertise_service", "service": "/a", "type": "b/C"}', "cannot offer services"),
            ('{"op": "set_level", "level": "loud"}', "level: expected"),
            ('\ufeff{"op": "set_level", "level": 7}', "level: expected"),
        ):
            other.connection.send(text)
            other.error(expected)
        other.connection.send("[" + "1," * 2_000_000 + "1]")
        with pytest.raises(ConnectionClosed) as closed:
            other.next()
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1009
    client.send("cancel_action_goal", id="g1")
    assert client.until("action_result", id="g1")["status"] == 5


def test_pages_of_other_sites_are_refused(gateway: RunningGateway) -> None:
    with (
        pytest.raises(InvalidStatus) as refused,
        client_of(gateway, origin="http://elsewhere.example"),  # type: ignore[arg-type]
    ):
        pass
    assert refused.value.response.status_code == 403
