"""A stop at a hub: it is done when the site says so, and comes to a site that was away, also from another process."""

import signal
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from tests.support.gateway import running_gateway
from tests.support.hubs import RunningHub, running_hub, site_settings, until_event
from tests.support.nats import nats_server
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros


def pending(hub: RunningHub) -> Any:
    return hub.get("/sites/berlin")["stop"]["pending"]


def test_a_stop_reaches_a_site_that_was_away(shared_domain: int, tmp_path: Path) -> None:
    with ExitStack() as stack:
        nats = stack.enter_context(nats_server(tmp_path))
        settings = site_settings(nats.url, tmp_path, "berlin") | {"hub_role": "supervisor"}
        berlin = stack.enter_context(running_gateway(shared_domain, **settings))
        hub = stack.enter_context(running_hub(nats.url, tmp_path))
        hub.wait_for_site("berlin")
        stopped = hub.http.post("/stop", json={"by": "Ada"})
        assert stopped.status_code == 200, stopped.text
        report = stopped.json()
        assert report["stopped"] == report["stop"]["robots"] == hub.get("/stop")["robots"] == ["/berlin"]
        assert report["stop"]["latched"]
        assert berlin.http.get("/stop").json()["by"] == "hub"
        released = hub.http.delete("/stop").raise_for_status().json()
        assert (released["latched"], released["sites"]["berlin"]["released"]) == (False, True)
        assert not berlin.http.get("/stop").json()["latched"]
        of_site = hub.http.post("/sites/berlin//STOP;v=1/", json={"by": "Ada"}).raise_for_status().json()
        assert (of_site["stopped"], of_site["stop"]["latched"]) == (["/"], True)
        assert berlin.http.get("/stop").json()["latched"]
        assert not hub.http.delete("/sites/berlin/stop").raise_for_status().json()["latched"]

        berlin.process.send_signal(signal.SIGKILL)
        berlin.process.wait()
        missed = hub.http.post("/stop", params={"robot": "/berlin"})
        assert (missed.status_code, missed.json()["code"]) == (504, "stop_incomplete")
        assert missed.json()["sites"]["berlin"]["repeated"]
        assert (missed.json()["stopped"], missed.json()["not_stopped"]) == ([], ["/berlin"])
        assert not hub.get("/stop")["latched"]
        with hub.stream("/ws/feedback?include=fleet") as stream:
            (site,) = until_event(stream, type="snapshot")["sites"]
            assert site["stop"]["pending"]["robots"] == ["/berlin"]
        hub.process.send_signal(signal.SIGKILL)
        hub.process.wait()
        hub = stack.enter_context(running_hub(nats.url, tmp_path))
        wait_until(lambda: pending(hub), "the stop is known to the next process")
        berlin = stack.enter_context(running_gateway(shared_domain, **settings))
        wait_until(lambda: berlin.http.get("/stop").json()["latched"], "the stop has come")
        wait_until(lambda: pending(hub) is None, "it is confirmed")
