"""`/foxglove`: what viewers send and get, on a real gateway with real ROS nodes."""

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import orjson
import pytest
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String
from websockets.exceptions import InvalidStatus
from websockets.typing import Subprotocol

from action_tutorials_interfaces.action import Fibonacci
from tests.extensions.foxglove.door import Client, client_of
from tests.support.access import Site, bearer, ends_with
from tests.support.clients import open_websocket
from tests.support.gateway import (
    RunningGateway,
    running_gateway_with_talker,
    running_talker,
)
from tests.support.installed import needs
from tests.support.processes import free_port
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

SCAN = "/talker0/scan"
FEEDBACK = "/fibonacci/_action/feedback"
# More steps than a test takes; the server accepts no more.
LONG = 45
# What clients may reach past goals and the latch.
ALLOWED = {
    "allow_publish": "/chatter,/cmd_vel",
    "allow_services": "/talker0/talker/*",
    "allow_parameters": "/talker0/talker",
}
PARAMETER = "/talker0/talker.use_sim_time"


FIBONACCI = "action_tutorials_interfaces/action/Fibonacci"
CHATTER = {"id": 1, "topic": "/chatter", "encoding": "cdr", "schemaName": "std_msgs/msg/String"}
# A request with one text, which is empty.
NO_TEXT = b"\0\1\0\0\1\0\0\0\0"


@pytest.fixture(scope="module")
def gateway(shared_domain: int) -> Iterator[RunningGateway]:
    with running_gateway_with_talker(shared_domain, **ALLOWED) as gateway:
        yield gateway


@pytest.fixture
def client(gateway: RunningGateway) -> Iterator[Client]:
    with client_of(gateway) as client:
        yield client


def test_channels_with_whole_definitions_and_their_messages(gateway: RunningGateway, client: Client) -> None:
    info = client.next()
    assert (info["op"], info["supportedEncodings"]) == ("serverInfo", ["cdr", "json"])
    assert client.next() == {"op": "advertise", "channels": []}
    channel = client.channel(SCAN)
    assert (channel["encoding"], channel["schemaName"]) == ("cdr", "sensor_msgs/msg/LaserScan")
    assert "MSG: builtin_interfaces/Time" in channel["schema"]
    assert channel["schemaEncoding"] == "ros2msg"
    wait_until(lambda: not gateway.http.get("/graph/topics/talker0/scan").json()["subscribers"], "no subscription")
    client.subscribe(7, SCAN)
    message = client.until("message", id=7)
    assert len(deserialize_message(message["data"], LaserScan).ranges) == 720
    assert message["stamp_ns"] > 1_700_000_000 * 10**9
    client.subscribe(9, "/talker0/latched")  # for everyone who comes
    client.until("message", id=9)
    client.send("unsubscribe", subscriptionIds=[7, 9, 1234])
    wait_until(lambda: not gateway.http.get("/graph/topics/talker0/scan").json()["subscribers"], "it leaves")


def test_the_feedback_of_an_action_and_topics_that_come_and_go(
    gateway: RunningGateway, client: Client, shared_domain: int
) -> None:
    client.subscribe(1, FEEDBACK)
    assert "uint8[16] uuid" in client.channel(FEEDBACK)["schema"]
    goal = client.ask("/fibonacci/send_goal", order=LONG)
    client.until("message", id=1)
    client.ask("/fibonacci/cancel_goal", **goal)
    with running_talker(shared_domain, "--topic", "passing:std_msgs/msg/String:5"):
        channel = client.channel("/talker0/passing")
        assert client.channel(FEEDBACK)["id"] != channel["id"]
    while channel["id"] not in client.until("unadvertise")["channelIds"]:
        pass


@needs("audit_log")
def test_a_goal_by_services(gateway: RunningGateway, client: Client) -> None:
    sent = client.call("/fibonacci/send_goal", serialize_message(Fibonacci.Goal(order=4)))
    assert b"accepted" in sent or b"executing" in sent
    offered = client.services["/fibonacci/get_result"]["response"]["schema"]
    assert offered.startswith("action_tutorials_interfaces/Fibonacci_Result result")
    result = client.call("/fibonacci/get_result", NO_TEXT)  # of the last one
    assert list(deserialize_message(result, Fibonacci.Result).sequence) == [0, 1, 1, 2, 3]
    assert b"succeeded" in result
    goal = client.ask("/fibonacci/send_goal", order=LONG)
    assert client.ask("/fibonacci/cancel_goal", goal_id=goal["goal_id"])["goal_id"] == goal["goal_id"]
    ended = client.ask("/fibonacci/get_result", goal_id=goal["goal_id"])
    assert (ended["status"], ended["goal_id"]) == ("canceled", goal["goal_id"])
    (newest, *_) = gateway.http.get("/actions/fibonacci/goals").json()["goals"]
    assert (newest["goal_id"], newest["origin"]) == (goal["goal_id"], "gateway")
    sent_goals = {"what": "send_goal"}
    wait_until(lambda: goal["goal_id"] in gateway.http.get("/audit", params=sent_goals).text, "the audit log")
    for name, request, reason in (
        ("/fibonacci/send_goal", b'{"order": "ten"}', "order: expected"),
        ("/fibonacci/send_goal", b'{"order": -1}', "rejected"),
        ("/fibonacci/get_result", b'{"goal_id": 7}', "goal_id"),
        ("/fibonacci/cancel_goal", orjson.dumps(goal), "already canceled"),
    ):
        assert reason in client.failure(name, request, "json")


def test_calls_beyond_the_limit_fail_and_a_cancel_passes(client: Client) -> None:
    goal = client.ask("/fibonacci/send_goal", order=LONG)
    request = orjson.dumps({"goal_id": goal["goal_id"]})
    for call in range(100, 165):  # each waits for the end of the goal
        client.begin("/fibonacci/get_result", request, "json", call)
    assert "64 operations" in client.until("serviceCallFailure", callId=164)["message"]
    client.begin("/fibonacci/cancel_goal", request, "json", 1)
    while client.until("response")["callId"] != 163:
        pass


def test_a_stop_holds_and_is_carried_out_whatever_its_request_is(gateway: RunningGateway, client: Client) -> None:
    goal = client.ask("/fibonacci/send_goal", order=LONG)
    assert b"latched" in client.call("/dock_gateway/stop", b"\xff\xff")
    assert "stop" in client.failure("/fibonacci/send_goal", b'{"order": 3}', "json")
    assert client.ask("/fibonacci/get_result", goal_id=goal["goal_id"])["status"] == "canceled"
    assert "latched" in client.ask("/dock_gateway/release_stop")["report"]
    assert client.ask("/fibonacci/send_goal", order=2)["goal_id"]


@needs("audit_log")
def test_services_parameters_and_the_connection_graph(gateway: RunningGateway, client: Client) -> None:
    client.send("getParameters", parameterNames=[PARAMETER, "/nobody.a"], id="g")
    assert client.until("parameterValues", id="g")["parameters"] == [{"name": PARAMETER, "value": False}]
    client.error("no node /nobody")
    client.send("getParameters", parameterNames=[], id="all")
    found = client.until("parameterValues", id="all")["parameters"]
    assert {PARAMETER, "/fibonacci_action_server.step_period"} <= {each["name"] for each in found}
    (step,) = (each for each in found if each["name"] == "/fibonacci_action_server.step_period")
    assert (step["value"], step["type"]) == (0.2, "float64")
    client.send("subscribeParameterUpdates", parameterNames=[PARAMETER])
    wait_until(lambda: gateway.http.get("/graph/topics/parameter_events").json()["subscribers"], "it listens")
    seen = list[dict[str, Any]]()
    while not any("id" not in each for each in seen):  # the change; each answer has an id
        client.send("setParameters", parameters=[{"name": PARAMETER, "value": False}], id="s")
        seen.append(client.until("parameterValues"))
    assert all(each["parameters"] == [{"name": PARAMETER, "value": False}] for each in seen)
    for parameter, reason in (
        ({"name": "/fibonacci_action_server.step_period", "value": 1.0}, "--allow-parameters"),
        ({"name": PARAMETER, "value": 7}, "expected a boolean"),
        ({"name": PARAMETER}, "not removed"),
        ({"name": "nothing", "value": 7}, "a node and a parameter"),
        ({"name": PARAMETER, "value": "!", "type": "byte_array"}, "base64"),
    ):
        client.send("setParameters", parameters=[parameter])
        client.error(reason)
    changes = {"what": "set_param"}
    wait_until(
        lambda: "/fibonacci_action_server step_period" in gateway.http.get("/audit", params=changes).text, "the audit"
    )
    client.send("subscribeConnectionGraph")
    graph = client.until("connectionGraphUpdate")
    assert {"name": SCAN, "publisherIds": ["/talker0/talker"]} in graph["publishedTopics"]
    client.send("unsubscribeConnectionGraph")
    client.send("unsubscribeParameterUpdates", parameterNames=[])
    wait_until(lambda: not gateway.http.get("/graph/topics/parameter_events").json()["subscribers"], "it leaves")


def test_messages_are_published_where_that_is_allowed(gateway: RunningGateway, client: Client) -> None:
    client.next()
    for identity, topic, fields, reason in (
        (1, "/other", {}, "--allow-publish '/other'"),
        (1, "/chatter", {"encoding": "protobuf"}, "encoding: expected one of cdr, json"),
        (1, "/chatter", {"schemaName": "nothing_msgs/msg/Nothing"}, "not installed"),
        (1, FEEDBACK, {"schemaName": f"{FIBONACCI}_FeedbackMessage"}, "belongs to an action"),
    ):
        client.send("advertise", channels=[CHATTER | {"id": identity, "topic": topic} | fields])
        client.error(reason)
    client.send("advertise", channels=[CHATTER, CHATTER, CHATTER | {"id": 2, "encoding": "json"}])
    client.error("is advertised already")
    client.connection.send(b"\x01\1\0\0\0" + serialize_message(String(data="first")))
    client.subscribe(5, "/chatter")
    wait_until(lambda: gateway.http.get("/graph/topics/chatter").json()["subscribers"], "it is subscribed to")
    client.connection.send(b"\x01\1\0\0\0" + serialize_message(String(data="a")))
    assert deserialize_message(client.until("message", id=5)["data"], String).data == "a"
    client.connection.send(b'\x01\2\0\0\0{"data": "b"}')
    assert deserialize_message(client.until("message", id=5)["data"], String).data == "b"
    for message, reason in (
        (b"\x01\1\0\0\0\xff\xff", "are no std_msgs/msg/String in CDR"),
        (b'\x01\2\0\0\0{"data": 7}', "data: expected"),
        (b"\x01\3\0\0\0x", "channel 3 is not advertised"),
    ):
        client.connection.send(message)
        client.error(reason)
    twist = {"id": 9, "topic": "/cmd_vel", "encoding": "json", "schemaName": "geometry_msgs/msg/Twist"}
    client.send("advertise", channels=[twist])
    assert gateway.http.post("/stop").status_code == 200
    client.connection.send(b"\x01\x09\0\0\0{}")
    client.error("stop")
    assert gateway.http.delete("/stop").status_code == 200
    client.send("unadvertise", channelIds=[1, 2, 3])
    client.connection.send(b"\x01\1\0\0\0")
    client.error("channel 1 is not advertised")


def test_bad_input_is_answered_and_nothing_is_lost(client: Client) -> None:
    client.subscribe(1, SCAN)
    client.until("message", id=1)
    scan, feedback = client.channel(SCAN)["id"], client.channel(FEEDBACK)["id"]
    for sent, expected in (
        ("{", "not JSON"),
        ("[" * 5000, "not JSON"),
        ("[]", "an object with op"),
        ('{"op": 7}', "op: expected"),
        ('{"op": "nonsense"}', "unknown operation 'nonsense'"),
        ('{"op": "fetchAsset", "uri": "package://a/b", "requestId": 1}', "no files"),
        ('{"op": "subscribe"}', "subscriptions: expected"),
        (subscription(2, "seven"), "subscriptions.0.channelId: expected"),
        (subscription(2**32, scan), "subscriptions.0.id: expected"),
        (subscription(-1, scan), "subscriptions.0.id: expected"),
        (subscription(2, 2**32 - 1), "no channel 4294967295"),
        (subscription(1, feedback), "subscription 1 already exists"),
        (subscription(2, scan), "is subscribed to"),
        ('{"op": "unsubscribe", "subscriptionIds": [true]}', "subscriptionIds.0: expected"),
        (b"", "a binary message"),
        (b"\x01\x00", "a binary message"),
        (b"\x02", "a binary message"),
        (b"\xff" * 500, "a binary message"),
        ('{"op": "getParameters", "parameterNames": "all"}', "parameterNames: expected"),
        ('{"op": "advertise", "channels": [{}]}', "channels.0.id: expected"),
    ):
        client.connection.send(sent)
        client.error(expected)
    client.connection.send(b"\x02" + struct.pack("<III", 1, 2, 3) + b"cdr")
    assert "no service 1" in client.until("serviceCallFailure", callId=2)["message"]
    client.connection.send(b"\x02" + struct.pack("<II", 1, 3) + b"\xff" * 4)  # cut off: it could be a stop
    assert "no service 1" in client.until("serviceCallFailure", callId=3)["message"]
    assert "encoding" in client.failure("/fibonacci/send_goal", b"", "protobuf")
    assert "in CDR" in client.failure("/fibonacci/send_goal", b"\x00\x01")
    assert "in CDR" in client.failure("/fibonacci/get_result", NO_TEXT[:-2] + b"\xff\xff")
    unknown = [{"id": number + 2, "channelId": number} for number in range(10_000)]
    client.send("subscribe", subscriptions=unknown)
    client.error("and 99")
    client.until("message", id=1)
    client.connection.send("[" + "1," * 2_000_000 + "1]")
    assert ends_with(client.connection)[0] == 1009


def subscription(identity: int, channel: object) -> str:
    return orjson.dumps({"op": "subscribe", "subscriptions": [{"id": identity, "channelId": channel}]}).decode()


@pytest.mark.usefixtures("gateway")  # its nodes
def test_a_port_of_its_own_subprotocols_tokens_and_tickets(shared_domain: int, tmp_path: Path) -> None:
    site, port = Site(tmp_path), free_port()
    token = site.token("viewer", "viewer", "--topic", "/talker0/b*")
    everyone = site.token("all", "viewer")
    sdk = [Subprotocol("other"), Subprotocol("foxglove.sdk.v1")]
    with site.gateway(shared_domain, foxglove_port=str(port)) as guarded:
        with pytest.raises(InvalidStatus) as refused, client_of(guarded):
            pass
        assert refused.value.response.status_code == 401
        with pytest.raises(InvalidStatus) as refused, client_of(guarded, subprotocols=None, **as_(token)):
            pass
        assert b"foxglove.sdk.v1 or foxglove.websocket.v1" in refused.value.response.body
        ticket = guarded.http.post("/session/ticket", headers=bearer(token)).json()["ticket"]
        url = f"ws://127.0.0.1:{port}/?ticket={ticket}"
        with open_websocket(url, subprotocols=sdk) as connection, client_of(guarded, **as_(token)) as other:
            client = Client(connection)
            assert connection.subprotocol == "foxglove.sdk.v1"
            client.subscribe(1, "/talker0/battery_status")
            with client_of(guarded, **as_(everyone)) as everything:
                hidden = everything.channel(SCAN)["id"]
            client.send("subscribe", subscriptions=[{"id": 2, "channelId": hidden}])
            client.error(f"there is no channel {hidden}")
            client.service("/fibonacci/get_result")
            assert [name for name in client.services if name.startswith("/fibonacci")] == ["/fibonacci/get_result"]
            client.send("setParameters", parameters=[{"name": PARAMETER, "value": True}])
            client.error("needs the role")
            assert SCAN not in client.channels
            other.channel("/talker0/battery_status")
            site.run("token", "delete", "viewer")
            assert ends_with(other.connection) == (4401, "invalid_token")


def as_(token: str) -> dict[str, Any]:
    return {"additional_headers": bearer(token)}


def test_pages_of_other_sites_are_refused(gateway: RunningGateway) -> None:
    with pytest.raises(InvalidStatus) as refused, client_of(gateway, origin="http://elsewhere.example"):
        pass
    assert refused.value.response.status_code == 403


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity"])
def test_a_number_that_is_none_is_refused_with_what_to_send(client: Client, number: str) -> None:
    client.send("advertise", channels=[CHATTER | {"encoding": "json"}])
    client.connection.send(b"\x01\1\0\0\0" + f'{{"data": {number}}}'.encode())
    client.error("send null instead of NaN; infinite numbers are not accepted")
