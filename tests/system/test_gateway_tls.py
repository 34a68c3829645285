"""A real gateway with TLS: every way in, renewed certificates, client certificates, and clients that misbehave."""

import os
import signal
import socket
import ssl
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from urllib.parse import urlsplit

import httpx2
import orjson
import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection

from tests.support.certificates import Authority, Pair
from tests.support.clients import HttpClient, connect, server_sent_events
from tests.support.gateway import LOW, RunningGateway, Stream, ready_gateway, running_gateway
from tests.support.processes import BIN, GONE_WITHIN, Process, free_port, ros_environment
from tests.support.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.ros

DOCKERFILE = Path(__file__).parents[2] / "backend" / "Dockerfile"
UPGRADE = (
    b"GET %s HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
)


@pytest.fixture(scope="module")
def authority(tmp_path_factory: pytest.TempPathFactory) -> Authority:
    return Authority(tmp_path_factory.mktemp("authority"))


@pytest.fixture(scope="module")
def pair(authority: Authority) -> Pair:
    return authority.issue()


@pytest.fixture(scope="module")
def gateway(shared_domain: int, pair: Pair) -> Iterator[RunningGateway]:
    settings = {"header_timeout": "5", "subscriber_timeout": "2", "subscriber_queue": "16"}
    with ready_gateway(shared_domain, **pair.settings, **settings) as gateway:
        gateway.publish(LOW)
        yield gateway


def address(gateway: RunningGateway) -> tuple[str, int]:
    parts = urlsplit(gateway.url)
    return str(parts.hostname), int(parts.port or 0)


def websocket(gateway: RunningGateway, path: str, context: ssl.SSLContext) -> ClientConnection:
    return connect(f"{gateway.url.replace('http', 'ws')}{path}", ssl=context)


def name(gateway: RunningGateway, context: ssl.SSLContext) -> str:
    """Connect, and return the name in the gateway's certificate."""
    with (
        socket.create_connection(address(gateway)) as plain,
        context.wrap_socket(plain, server_hostname="localhost") as tls,
    ):
        certificate = tls.getpeercert()
        assert certificate is not None
        return str(dict(item for part in certificate["subject"] for item in part)["commonName"])  # type: ignore[misc]


@contextmanager
def silent(gateway: RunningGateway, sent: bytes, count: int) -> Iterator[list[socket.socket]]:
    """Clients that complete no handshake."""
    with ExitStack() as stack:
        clients = [stack.enter_context(socket.create_connection(address(gateway))) for _ in range(count)]
        for client in clients:
            client.sendall(sent)
        yield clients


def run(gateway: RunningGateway, *command: str, **environment: str) -> subprocess.CompletedProcess[str]:
    variables = {**os.environ, "DOCK_GATEWAY_URL": gateway.url, **environment}
    return subprocess.run([BIN / "dock-gateway", *command], env=variables, capture_output=True, text=True, check=False)


def test_every_way_in(gateway: RunningGateway, authority: Authority) -> None:
    assert gateway.url.startswith("https://")
    context = authority.context()
    with httpx2.Client(base_url=gateway.url, verify=context, trust_env=False, timeout=PATIENCE) as http:
        answer = http.get("/healthz")
        assert answer.status_code == 200
        assert answer.headers["Strict-Transport-Security"] == "max-age=31536000"
        with websocket(gateway, "/ws/feedback", context) as connection, websocket(gateway, "/ws", context) as commands:
            stream = Stream(connection)
            commands.send(orjson.dumps({"op": "send_goal", "id": "1"}).decode())
            goal_id = stream.until_type("feedback")["goal_id"]
            with gateway.http.stream("GET", f"/goals/{goal_id}/events") as events:
                kinds = (document["type"] for _, document in server_sent_events(events))
                assert "feedback" in kinds
            assert http.post(f"/goals/{goal_id}/cancel", headers={"Origin": gateway.url}).is_success
            assert stream.until_type("result")["status"] == "canceled"


def test_clients_get_no_session_tickets(gateway: RunningGateway, authority: Authority) -> None:
    """One that comes while `websockets.sync` writes its first request can lose it: it waits for an answer in vain."""
    with (
        socket.create_connection(address(gateway)) as plain,
        authority.context().wrap_socket(plain, server_hostname="localhost") as tls,
    ):
        tls.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n")
        assert tls.recv(100).startswith(b"HTTP/1.1 200")  # a ticket would stand before the answer
        assert tls.version() == "TLSv1.3"
        assert tls.session is not None
        assert not tls.session.has_ticket


def test_the_cookie_is_secure(domain: int, pair: Pair, tmp_path: Path) -> None:
    stored = {"database_url": f"sqlite:///{tmp_path}/history.db"}
    with running_gateway(domain, **pair.settings, **stored, authentication="true") as gateway:
        created = run(
            gateway, "token", "create", "ada", "--role", "admin", DOCK_GATEWAY_DATABASE_URL=stored["database_url"]
        )
        secret = created.stdout.strip()

        def log_in() -> str | None:
            cookie: str | None = gateway.http.post("/session", json={"token": secret}).headers.get("set-cookie")
            return cookie

        cookie = wait_until(log_in, "the token")
        assert cookie.startswith("__Host-dock-gateway=")
        assert "secure" in cookie.lower()


def test_plain_http_is_told_to_use_https(gateway: RunningGateway) -> None:
    with HttpClient(gateway.url.replace("https", "http")) as http:
        answer = http.get("/healthz")
        assert (answer.status_code, answer.json()["code"]) == (400, "tls_required")
        assert "Strict-Transport-Security" not in answer.headers
    refused = run(gateway, "battery", DOCK_GATEWAY_URL=gateway.url.replace("https", "http"))
    assert "tls_required" in refused.stderr


def test_the_command_line(gateway: RunningGateway, authority: Authority) -> None:
    trusted = run(gateway, "battery", SSL_CERT_FILE=str(authority.file))
    assert trusted.returncode == 0, trusted.stderr
    assert "NOT CHARGING" in trusted.stdout
    unknown = run(gateway, "battery")
    assert unknown.returncode == 1
    assert "CERTIFICATE_VERIFY_FAILED" in unknown.stderr
    goal = run(gateway, "dock", "--no-wait", SSL_CERT_FILE=str(authority.file)).stdout.strip()
    following = subprocess.Popen(
        [BIN / "dock-gateway", "watch", goal],
        env={**os.environ, "DOCK_GATEWAY_URL": gateway.url, "SSL_CERT_FILE": str(authority.file)},
        stdout=subprocess.PIPE,
        text=True,
    )
    with following:
        gateway.http.post(f"/goals/{goal}/cancel").raise_for_status()
        output, _ = following.communicate(timeout=PATIENCE)
    assert "canceled" in output


@pytest.mark.parametrize("sent", [b"", b"\x16", b"\x16\x03\x01\x02\x00\x01"])
def test_clients_that_complete_no_handshake_are_dropped_and_others_are_served(
    gateway: RunningGateway, sent: bytes
) -> None:
    with silent(gateway, sent, 100) as clients:
        with HttpClient(gateway.url) as http:
            assert http.get("/healthz").status_code == 200
        for client in clients:
            client.settimeout(PATIENCE)
            assert client.recv(1) == b""
    assert "Traceback" not in gateway.process.output


def test_a_reader_that_never_reads_is_cut_off_and_slows_nobody(gateway: RunningGateway, authority: Authority) -> None:
    state = LOW | {"location": "x" * 60_000}
    context = authority.context()
    with ExitStack() as stack:
        reader = Stream(stack.enter_context(websocket(gateway, "/ws/feedback?include=battery", context)))
        plain = stack.enter_context(socket.socket())
        plain.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        plain.connect(address(gateway))
        sleeper = stack.enter_context(context.wrap_socket(plain, server_hostname="localhost"))
        sleeper.sendall(UPGRADE % b"/ws/feedback?include=battery")
        wait_until(lambda: gateway.http.get("/healthz").json()["subscribers"] == 2, "both readers")
        gateway.http.put("/battery/publisher", json={"state": state, "rate_hz": 100}).raise_for_status()
        deadline = time.monotonic() + PATIENCE
        while gateway.http.get("/healthz").json()["subscribers"] > 1:
            assert time.monotonic() < deadline, "the sleeper was not cut off"
            reader.until_type("battery")
    assert not [event for event in reader.seen if event["type"] == "dropped"]
    gateway.publish(LOW)
    assert "Traceback" not in gateway.process.output


def test_a_renewed_certificate_is_used_and_a_broken_one_is_not(
    domain: int, authority: Authority, tmp_path: Path
) -> None:
    pair = Pair(tmp_path / "cert.pem", tmp_path / "key.pem")
    authority.issue("first", into=pair)
    context = authority.context()
    with running_gateway(domain, **pair.settings) as gateway, websocket(gateway, "/ws/feedback", context) as open_one:
        assert name(gateway, context) == "first"
        good = pair.key.read_bytes()
        pair.key.write_text("broken")
        gateway.process.wait_for("the old one remains in use")
        assert name(gateway, context) == "first"
        pair.key.write_bytes(good)
        authority.issue("second", into=pair)
        wait_until(lambda: name(gateway, context) == "second", "the renewed certificate")
        Stream(open_one).until_type("heartbeat")
        assert "Traceback" not in gateway.process.output


def check_health(gateway: RunningGateway, **environment: str) -> int:
    """Run the health check of the image."""
    command = next(line for line in DOCKERFILE.read_text().splitlines() if line.startswith("    CMD ["))
    _, *arguments = orjson.loads(command.removeprefix("    CMD "))
    variables = {"DOCK_GATEWAY_PORT": str(address(gateway)[1]), **environment}
    return subprocess.run([sys.executable, *arguments], env=variables, capture_output=True, check=False).returncode


def test_the_health_check_of_the_image(gateway: RunningGateway, pair: Pair) -> None:
    assert check_health(gateway, DOCK_GATEWAY_TLS_CERT=str(pair.cert)) == 0
    assert check_health(gateway) == 1


def test_up_announces_itself(domain: int, pair: Pair) -> None:
    port = free_port()
    options = (f"--tls-cert={pair.cert}", f"--tls-key={pair.key}", f"--port={port}", "--database-url=memory:")
    with Process(str(BIN / "dock-gateway"), "up", "--no-sim", *options, env=ros_environment(domain)) as process:
        process.wait_for(f"dock-gateway is ready: open https://127.0.0.1:{port}")


def test_mutual_tls(domain: int, pair: Pair, authority: Authority, tmp_path: Path) -> None:
    client = authority.issue("operator")
    both = tmp_path / "both.pem"
    both.write_bytes(client.cert.read_bytes() + client.key.read_bytes())
    with running_gateway(domain, **pair.settings, tls_client_ca=str(authority.file)) as gateway:
        with (
            pytest.raises(httpx2.TransportError),
            httpx2.Client(verify=authority.context(), trust_env=False) as stranger,
        ):
            stranger.get(f"{gateway.url}/healthz")
        context = authority.context(client)
        with httpx2.Client(verify=context, trust_env=False, timeout=PATIENCE) as http:
            assert http.get(f"{gateway.url}/healthz").status_code == 200
        with websocket(gateway, "/ws/feedback", context) as connection:
            Stream(connection).until_type("snapshot")
        own = {"SSL_CERT_FILE": str(authority.file)}
        assert run(gateway, "battery", **own, DOCK_GATEWAY_CLIENT_CERT=str(both)).returncode == 0
        assert run(gateway, "battery", **own).returncode == 1
        own_certificate = {"DOCK_GATEWAY_TLS_CERT": str(pair.cert), "DOCK_GATEWAY_CLIENT_CERT": str(both)}
        assert check_health(gateway, **own_certificate) == 0
        missing = run(gateway, "battery", **own, DOCK_GATEWAY_CLIENT_CERT="/nowhere.pem")
        assert "DOCK_GATEWAY_CLIENT_CERT: /nowhere.pem" in missing.stderr
        assert "Traceback" not in gateway.process.output + missing.stderr


def test_it_ends_in_time_with_open_connections(domain: int, pair: Pair, authority: Authority) -> None:
    """Streams, idle connections whose clients do not read, and handshakes that are not complete."""
    context = authority.context()
    with ExitStack() as stack:
        gateway = stack.enter_context(running_gateway(domain, **pair.settings))
        streams = [stack.enter_context(websocket(gateway, "/ws/feedback", context)) for _ in range(20)]
        for _ in range(5):
            idle = stack.enter_context(HttpClient(gateway.url))
            assert idle.get("/healthz").status_code == 200
        stack.enter_context(silent(gateway, b"\x16", 20))
        began = time.monotonic()
        gateway.process.send_signal(signal.SIGTERM)
        gateway.process.wait()
        assert time.monotonic() - began < GONE_WITHIN
        for connection in streams:
            assert Stream(connection).until_type("closing")["reason"] == "shutting_down"
            with pytest.raises(ConnectionClosed) as closed:
                connection.recv()
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.code == 1012
        assert "ERROR" not in gateway.process.output
        assert "Traceback" not in gateway.process.output


@pytest.mark.parametrize(
    ("cert", "key", "said"),
    [
        ("{cert}", "/nowhere.key", "/nowhere.key cannot be read: No such file"),
        ("{cert}", "{other}", "is not that of the certificate in"),
        ("{cert}", "", "set both or neither"),
    ],
)
def test_files_that_cannot_be_used(authority: Authority, pair: Pair, cert: str, key: str, said: str) -> None:
    files = {"cert": pair.cert, "other": authority.issue("other").key}
    options = (f"--tls-cert={cert.format(**files)}", f"--tls-key={key.format(**files)}")
    refused = subprocess.run(
        [BIN / "dock-gateway", "serve", *options], capture_output=True, text=True, timeout=PATIENCE, check=False
    )
    assert refused.returncode == 2
    assert said in " ".join(refused.stderr.split())
    assert "Traceback" not in refused.stderr
