"""Tokens of a real gateway: made on the command line, revoked while streams are open and a goal runs."""

from contextlib import ExitStack
from pathlib import Path

import orjson
import pytest
from websockets.exceptions import InvalidStatus

from tests.support.access import Site, bearer, ends_with, stream
from tests.support.gateway import LOW, running_dock_server
from tests.support.processes import ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

INVALID_TOKEN = 4401


@pytest.fixture
def site(tmp_path: Path) -> Site:
    return Site(tmp_path)


def test_roles_over_every_way(domain: int, site: Site) -> None:
    viewer, operator, supervisor = (site.token(role, role) for role in ("viewer", "operator", "supervisor"))
    with running_dock_server(domain), site.gateway(domain) as gateway:
        gateway.wait_until_ready()
        assert gateway.http.post("/dock").json()["code"] == "not_authenticated"
        assert gateway.http.post("/dock", headers=bearer(viewer)).json()["code"] == "role_required"
        with pytest.raises(InvalidStatus) as refused, stream(gateway, "/ws/feedback", "dgw_wrong"):
            pass
        assert refused.value.response.status_code == 401

        with stream(gateway, "/ws", viewer) as socket:
            socket.send(orjson.dumps({"op": "send_goal", "id": "1"}).decode())
            assert orjson.loads(socket.recv())["error"]["code"] == "role_required"
            socket.send(orjson.dumps({"op": "stop", "id": "2", "by": "somebody else"}).decode())
            assert orjson.loads(socket.recv())["stop"]["by"] == "viewer"
            socket.send(orjson.dumps({"op": "release_stop", "id": "3"}).decode())
            assert orjson.loads(socket.recv())["error"]["code"] == "role_required"
        assert gateway.http.delete("/stop", headers=bearer(operator)).status_code == 403
        assert gateway.http.delete("/stop", headers=bearer(supervisor)).status_code == 200
        sent = gateway.http.post("/dock", headers=bearer(operator))
        assert sent.status_code == 202, sent.text

        commands = {"DOCK_GATEWAY_URL": gateway.url}
        assert "not_authenticated" in site.run("stop", **commands).output
        stopped = site.run("stop", **commands, DOCK_GATEWAY_TOKEN=viewer)
        assert stopped.returncode == 0, stopped.output
        state = gateway.http.get("/stop", headers=bearer(viewer)).json()
        assert (state["latched"], state["by"]) == (True, "viewer")


def test_a_revoked_token_ends_its_streams_and_no_goal(domain: int, site: Site) -> None:
    """The command line revokes it, in another process than the gateway's; other tokens go on."""
    cron, other = site.token("cron", "operator"), site.token("other", "supervisor")
    with running_dock_server(domain), site.gateway(domain) as gateway:
        gateway.wait_until_ready()
        body = {"state": LOW, "rate_hz": 10}
        gateway.http.put("/battery/publisher", json=body, headers=bearer(other)).raise_for_status()
        goal = gateway.http.post("/dock", headers=bearer(cron)).raise_for_status().json()
        paths = ("/ws/feedback", "/ws", "/ws/topics?topic=/battery_status")
        with ExitStack() as stack:
            sockets = [stack.enter_context(stream(gateway, path, cron)) for path in paths]
            reader = stack.enter_context(stream(gateway, "/ws/feedback", other))
            sse = gateway.http.stream("GET", f"/goals/{goal['goal_id']}/events", headers=bearer(cron))
            events = stack.enter_context(sse)
            assert site.run("token", "delete", "cron").returncode == 0
            assert [ends_with(socket) for socket in sockets] == [(INVALID_TOKEN, "invalid_token")] * len(paths)
            assert "invalid_token" in "".join(events.iter_text())
            assert gateway.http.post("/dock", headers=bearer(cron)).json()["code"] == "invalid_token"
            assert orjson.loads(reader.recv())["type"] == "snapshot"
            running = gateway.http.get(f"/goals/{goal['goal_id']}", headers=bearer(other)).json()
            assert running["status"] == "executing"
            while orjson.loads(reader.recv())["type"] != "feedback":
                pass
        gateway.http.post("/stop", headers=bearer(other)).raise_for_status()


def test_tokens_survive_a_restart_and_new_ones_come_by_themselves(shared_domain: int, site: Site) -> None:
    admin = site.token("ada", "admin")
    with site.gateway(shared_domain):
        pass
    with site.gateway(shared_domain) as gateway:
        assert gateway.http.get("/robots", headers=bearer(admin)).status_code == 200
        late = site.token("late", "viewer")
        wait_until(lambda: gateway.http.get("/robots", headers=bearer(late)).status_code == 200, "the new token")
    listed = site.run("token", "list").output
    assert all(text in listed for text in ("admin", "ada", "late"))
    assert admin not in listed
    assert "there is no token nobody" in site.run("token", "delete", "nobody").output
    assert "token_exists" in site.run("token", "create", "ada").output


def test_an_open_gateway_on_the_network_is_refused(shared_domain: int, site: Site) -> None:
    options = ("serve", "--port", "0", "--host", "0.0.0.0")
    refused = site.run(*options, **ros_environment(shared_domain))
    assert refused.returncode == 2
    assert "--authentication" in refused.output
    with site.gateway(shared_domain, host="0.0.0.0", allow_open="true", authentication="false") as gateway:
        assert gateway.http.get("/session").json()["open_to"] == "network"
        assert "OPEN TO THE NETWORK" in gateway.process.output
    memory = site.run("serve", "--authentication", "--database-url", "memory:")
    assert "authentication needs a database" in memory.output
