"""The audit log of real gateways: over HTTP and `/ws`, through kills and outages, with one database for two."""

import signal
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import orjson
import pytest

from tests.support.access import Site, bearer
from tests.support.clients import connect
from tests.support.gateway import RunningGateway, running_gateway
from tests.support.history import locked
from tests.support.postgresql import binaries, running_postgresql
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros


def records(gateway: RunningGateway, secret: str, **wanted: str) -> list[dict[str, Any]]:
    answer = gateway.http.get("/audit", params=wanted, headers=bearer(secret)).raise_for_status()
    found: list[dict[str, Any]] = answer.json()["records"]
    return found


def verify(site: Site, *options: str) -> str:
    done = site.run("audit", "verify", *options)
    assert done.returncode == 0, done.output
    return done.output


def test_every_way_leaves_its_record_and_a_kill_loses_no_release(shared_domain: int, tmp_path: Path) -> None:
    site = Site(tmp_path)
    ada, viewer = site.token("ada", "admin"), site.token("vera", "viewer")
    with site.gateway(shared_domain) as gateway:
        named = bearer(viewer) | {"X-Request-ID": "r-1"}
        gateway.http.post("/stop", json={"by": "mallory"}, headers=named).raise_for_status()
        assert gateway.http.delete("/stop", headers=bearer(viewer)).status_code == 403
        address = f"{gateway.url.replace('http', 'ws')}/ws"
        with connect(address, additional_headers=bearer(ada)) as socket:
            socket.send(orjson.dumps({"op": "ping", "id": "1"}).decode())
            socket.recv()
            socket.send(orjson.dumps({"op": "release_stop", "id": "2", "by": "mallory"}).decode())
            assert orjson.loads(socket.recv())["error"]["code"] == "invalid_field"
            socket.send(orjson.dumps({"op": "release_stop", "id": "3"}).decode())
            assert orjson.loads(socket.recv())["op"] == "ack"
        gateway.process.send_signal(signal.SIGKILL)  # at once after the answer
    assert "rows are intact" in verify(site)
    with site.gateway(shared_domain) as gateway:
        found = wait_until(lambda: records(gateway, ada), "the records")
        newest_first = [(each["what"], each["principal"], each["status"], each["code"]) for each in found]
        assert newest_first[:4] == [
            ("release_stop", "ada", 200, None),
            ("release_stop", "ada", 422, "invalid_field"),
            ("release_stop", "vera", 403, "role_required"),
            ("stop", "vera", 200, None),
        ]
        assert {each["client"] for each in found} == {"127.0.0.1"}
        assert {each["robot"] for each in found} == {"/"}
        assert found[3]["request_id"] == "r-1"
        assert all(each["request_id"] for each in found)
        wait_until(lambda: records(gateway, ada, what="list_audit"), "the record of the reading")
        digest = records(gateway, ada)[0]["digest"]
        verify(site, "--expect", digest)  # while the gateway runs
        assert '"what":"list_audit"' in gateway.process.output


def test_a_release_while_the_history_is_away(shared_domain: int, tmp_path: Path) -> None:
    site = Site(tmp_path)
    ada = site.token("ada", "admin")
    with site.gateway(shared_domain) as gateway:
        gateway.wait_until_stored()
        gateway.http.post("/stop", headers=bearer(ada)).raise_for_status()
        wait_until(lambda: records(gateway, ada, what="stop"), "the stop")
        with locked(site.database.removeprefix("sqlite:///")):
            for _ in range(2):
                gateway.http.delete("/stop", headers=bearer(ada)).raise_for_status()
        wait_until(lambda: len(records(gateway, ada, what="release_stop")) == 2, "the releases, later")
    verify(site)


def test_records_outlast_a_gateway_that_ends_while_the_history_is_away(shared_domain: int, tmp_path: Path) -> None:
    site = Site(tmp_path)
    ada = site.token("ada", "admin")
    spool = {"spool_path": f"{tmp_path}/spool"}
    with site.gateway(shared_domain, **spool) as gateway:
        gateway.wait_until_stored()
        with locked(site.database.removeprefix("sqlite:///")):
            gateway.http.post("/stop", headers=bearer(ada)).raise_for_status()
            gateway.process.send_signal(signal.SIGTERM)
            gateway.process.wait()
    with site.gateway(shared_domain, **spool) as gateway:
        wait_until(lambda: records(gateway, ada, what="stop"), "the stop")
    verify(site)


def test_two_gateways_write_one_chain_and_one_is_killed(shared_domain: int, tmp_path: Path) -> None:
    if binaries() is None:
        pytest.skip("PostgreSQL IS NOT TESTED: there is no server on this machine, and no package with one for it")
    with running_postgresql() as server, ThreadPoolExecutor(4) as threads:
        options = {"database_url": server.url}
        with running_gateway(shared_domain, **options) as first, running_gateway(shared_domain, **options) as second:
            for gateway in (first, second):
                gateway.wait_until_stored()

            def release(gateway: RunningGateway, times: int) -> None:
                for _ in range(times):
                    gateway.http.delete("/stop").raise_for_status()

            for done in [threads.submit(release, gateway, 20) for gateway in (first, second)]:
                done.result()
            going_on = threads.submit(release, first, 20)
            gateway = second
            second.process.send_signal(signal.SIGKILL)
            going_on.result()
            found = first.http.get("/audit", params={"limit": 500, "what": "release_stop"}).json()["records"]
            assert len(found) == 60
        site = Site(tmp_path)
        site.database = server.url
        assert "rows are intact" in verify(site)
