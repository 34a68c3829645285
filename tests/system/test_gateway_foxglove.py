"""`/foxglove`: what viewers send and get, on a real gateway with real ROS nodes."""

import struct
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import orjson
import pytest
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import LaserScan
from websockets.exceptions import InvalidStatus
from websockets.sync.client import ClientConnection
from websockets.sync.client import connect as open_websocket
from websockets.typing import Subprotocol

from tests.support.access import Site, bearer, ends_with
from tests.support.gateway import RunningGateway, running_gateway, running_program, running_talker
from tests.support.processes import free_port
from tests.support.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.ros

SCAN = "/talker0/scan"
FEEDBACK = "/fibonacci/_action/feedback"


class Client:
    """A viewer: keeps what it is offered and sent."""

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection
        self.channels: dict[str, dict[str, Any]] = {}
        self.messages: list[tuple[int, bytes]] = []

    def send(self, op: str, **fields: Any) -> None:
        self.connection.send(orjson.dumps({"op": op, **fields}).decode())

    def next(self) -> dict[str, Any]:
        data = self.connection.recv(PATIENCE)
        if isinstance(data, str):
            message: dict[str, Any] = orjson.loads(data)
        else:
            message = self.read(data)
        if message["op"] == "advertise":
            self.channels |= {each["topic"]: each for each in message["channels"]}
        return message

    def read(self, data: bytes) -> dict[str, Any]:
        opcode, identity, stamp_ns = struct.unpack_from("<BIQ", data)
        assert opcode == 1
        self.messages.append((identity, data[13:]))
        return {"op": "message", "id": identity, "stamp_ns": stamp_ns, "data": data[13:]}

    def until(self, op: str, **fields: Any) -> dict[str, Any]:
        """The next message of this kind with these fields."""
        while (message := self.next())["op"] != op or not fields.items() <= message.items():
            pass
        return message

    def channel(self, topic: str) -> dict[str, Any]:
        """The channel of a topic, as soon as it is offered."""
        while topic not in self.channels:
            self.next()
        return self.channels[topic]

    def subscribe(self, identity: int, topic: str) -> None:
        self.send("subscribe", subscriptions=[{"id": identity, "channelId": self.channel(topic)["id"]}])

    def error(self, text: str) -> None:
        message = self.until("status", level=2)
        assert text in message["message"]


@contextmanager
def client_of(gateway: RunningGateway, query: str = "", **options: Any) -> Iterator[Client]:
    url = f"{gateway.url.replace('http', 'ws')}/foxglove{query}"
    options = {"subprotocols": [Subprotocol("foxglove.websocket.v1")], **options}
    with open_websocket(url, max_size=None, **options) as connection:
        yield Client(connection)


@pytest.fixture(scope="module")
def gateway(shared_domain: int) -> Iterator[RunningGateway]:
    with ExitStack() as stack:
        topics = ("--long", "720", "--topic", "scan:sensor_msgs/msg/LaserScan:20")
        latched = ("--topic", "latched:std_msgs/msg/String:latched")
        stack.enter_context(running_talker(shared_domain, *topics, *latched))
        stack.enter_context(running_program(shared_domain, "fibonacci_action_server", "-p", "step_period:=0.2"))
        gateway = stack.enter_context(running_gateway(shared_domain, server_wait="1"))
        wait_until(lambda: gateway.http.get("/actions/fibonacci").status_code == 200, "the action")
        wait_until(lambda: gateway.http.get("/graph/topics/talker0/scan").status_code == 200, "the topic")
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
    assert not gateway.http.get("/graph/topics/talker0/scan").json()["subscribers"]
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
    assert gateway.http.post("/actions/fibonacci/goals", json={"order": 3}).status_code == 202
    client.until("message", id=1)
    with running_talker(shared_domain, "--topic", "passing:std_msgs/msg/String:5"):
        channel = client.channel("/talker0/passing")
        assert client.channel(FEEDBACK)["id"] != channel["id"]
    while channel["id"] not in client.until("unadvertise")["channelIds"]:
        pass


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
        (b"\x02\x01\x00\x00\x00\x01\x00\x00\x00\xff\xff\xff\xff", "a binary message"),
        (b"\xff" * 500, "a binary message"),
    ):
        client.connection.send(sent)
        client.error(expected)
    unknown = [{"id": number + 2, "channelId": number} for number in range(10_000)]
    client.send("subscribe", subscriptions=unknown)
    client.error("and 99")
    client.until("message", id=1)
    client.connection.send("[" + "1," * 2_000_000 + "1]")
    assert ends_with(client.connection)[0] == 1009


def subscription(identity: int, channel: object) -> str:
    return orjson.dumps({"op": "subscribe", "subscriptions": [{"id": identity, "channelId": channel}]}).decode()


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
            assert SCAN not in client.channels
            other.channel("/talker0/battery_status")
            site.run("token", "revoke", "viewer")
            assert ends_with(other.connection) == (4401, "invalid_token")


def as_(token: str) -> dict[str, Any]:
    return {"additional_headers": bearer(token)}


def test_pages_of_other_sites_are_refused(gateway: RunningGateway) -> None:
    with pytest.raises(InvalidStatus) as refused, client_of(gateway, origin="http://elsewhere.example"):
        pass
    assert refused.value.response.status_code == 403
