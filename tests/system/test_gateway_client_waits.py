"""What a client waits for at a real gateway: a slow service, a goal that runs, a person, a gateway that hangs."""

import asyncio
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import aclosing, contextmanager

import pytest

from dock_gateway.client import AsyncClient, Client, ClientError, ClientTimeout, GatewayRefused
from tests.support.access import Site, bearer
from tests.support.gateway import RunningGateway, running_program, running_service_node
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

# Seconds of a client for its answers, shorter than what it waits for here; and what a busy machine needs in addition.
TIMEOUT, SLACK = 1.0, 6.0
SILENT = "/robot1/never"
LONG = {"order": 45}


@pytest.fixture(scope="module")
def tokens(site: Site) -> dict[str, str]:
    return {role: site.token(role, role) for role in ("agent", "operator")}


@pytest.fixture(scope="module")
def gateway(shared_domain: int, site: Site, tokens: dict[str, str]) -> Iterator[RunningGateway]:
    with (
        running_service_node(shared_domain),
        running_program(shared_domain, "fibonacci_action_server", "-p", "step_period:=0.5"),
        site.gateway(shared_domain, allow_services=SILENT) as gateway,
    ):
        gateway.http.headers["Authorization"] = f"Bearer {tokens['operator']}"
        wait_until(lambda: gateway.http.get("/actions/fibonacci").status_code == 200, "the action")
        wait_until(lambda: any(each["name"] == SILENT for each in services(gateway)), "the service")
        yield gateway


def services(gateway: RunningGateway) -> list[dict[str, str]]:
    found: list[dict[str, str]] = gateway.http.get("/graph").json()["services"]
    return found


def client_of(gateway: RunningGateway, token: str) -> Client:
    return Client(gateway.url, token=token, timeout=TIMEOUT, patience=TIMEOUT)


@contextmanager
def hanging(gateway: RunningGateway) -> Iterator[None]:
    """The gateway is there, and does nothing."""
    gateway.process.send_signal(signal.SIGSTOP)
    try:
        yield
    finally:
        gateway.process.send_signal(signal.SIGCONT)


def test_a_service_may_take_the_time_that_its_call_says(gateway: RunningGateway, tokens: dict[str, str]) -> None:
    """The gateway gives up first, and says so; the client does not take that for a gateway that is gone."""
    with client_of(gateway, tokens["operator"]) as client:
        began = time.monotonic()
        with pytest.raises(GatewayRefused) as refused:
            client.call_service(SILENT, timeout=3 * TIMEOUT)
    assert refused.value.code == "service_timeout"
    assert time.monotonic() - began >= 3 * TIMEOUT

    async def call() -> None:
        async with AsyncClient(gateway.url, token=tokens["operator"], timeout=TIMEOUT) as client:
            await client.call_service(SILENT, timeout=3 * TIMEOUT)

    with pytest.raises(GatewayRefused) as refused:
        asyncio.run(call())
    assert refused.value.code == "service_timeout"


def test_the_end_of_a_goal_is_waited_for(gateway: RunningGateway, tokens: dict[str, str]) -> None:
    with client_of(gateway, tokens["operator"]) as client:
        ended = client.request("POST", "/actions/fibonacci/goals", {"order": 6}, wait=30)
        assert ended["status"] == "succeeded"
        began = time.monotonic()
        running = client.request("POST", "/actions/fibonacci/goals", LONG, wait=3)
        assert running["status"] == "executing"
        assert time.monotonic() - began >= 3 * TIMEOUT
        client.goal(running["goal_id"]).cancel()


def test_a_goal_waits_for_a_person_who_takes_longer_than_an_answer_may(
    gateway: RunningGateway, tokens: dict[str, str]
) -> None:
    """It is sent again with its key meanwhile; one goal is asked for, and one is sent."""
    asked: set[str] = set()

    def approve(seconds: float) -> None:
        until = time.monotonic() + seconds
        while time.monotonic() < until or not asked:
            asked.update(each["id"] for each in gateway.http.get("/approvals").json()["approvals"])
            time.sleep(0.1)
        (approval,) = asked
        gateway.http.put(f"/approvals/{approval}/decision", json={"allow": True}).raise_for_status()

    before = len(gateway.http.get("/actions/fibonacci/goals").json()["goals"])
    with ThreadPoolExecutor() as threads, client_of(gateway, tokens["agent"]) as client:
        person = threads.submit(approve, 4 * TIMEOUT)
        goal = client.send("/fibonacci", {"order": 2})
        person.result()
        assert goal.result(timeout=30).result
    assert len(gateway.http.get("/actions/fibonacci/goals").json()["goals"]) == before + 1


def test_a_gateway_that_hangs_is_a_timeout_in_time(gateway: RunningGateway, tokens: dict[str, str]) -> None:
    with client_of(gateway, tokens["operator"]) as client:
        goal = client.send("/fibonacci", LONG)
        with hanging(gateway):
            for ask, seconds in (
                (lambda: goal.wait(timeout=1), 1),
                (lambda: client.stop(latch=False), TIMEOUT + 2),
                (lambda: client.call_service(SILENT, timeout=2), TIMEOUT + 2),
                (client.robots, 2 * TIMEOUT),
            ):
                began = time.monotonic()
                with pytest.raises(ClientTimeout) as timed_out:
                    ask()
                assert isinstance(timed_out.value, ClientError | TimeoutError)
                assert seconds - 0.1 <= time.monotonic() - began < seconds + SLACK
        goal.wait(timeout=30)  # the stop was carried out, as its error says that it may be

    async def wait() -> None:
        async with AsyncClient(gateway.url, token=tokens["operator"], timeout=TIMEOUT) as client:
            goal = await client.send("/fibonacci", LONG)
            async with aclosing(goal.events()) as events:
                await anext(events)
                with hanging(gateway):
                    began = time.monotonic()
                    with pytest.raises(TimeoutError):
                        await asyncio.wait_for(goal.wait(), 1.5)
                    await events.aclose()
                    assert 1.5 <= time.monotonic() - began < 1.5 + SLACK
            await goal.cancel()

    asyncio.run(wait())


def test_a_command_says_that_the_gateway_does_not_answer(gateway: RunningGateway, tokens: dict[str, str]) -> None:
    command = [sys.executable, "-m", "dock_gateway", "stop", "--url", gateway.url]
    with hanging(gateway):
        done = subprocess.run(
            command, env={"DOCK_GATEWAY_TOKEN": tokens["operator"]}, capture_output=True, text=True, check=False
        )
    assert done.returncode == 1
    assert "the stop is NOT confirmed" in done.stderr
    assert "has not answered within 6" in done.stderr
    assert "may be carried out" in done.stderr
    wait_until(lambda: gateway.http.get("/stop", headers=bearer(tokens["operator"])).is_success, "the gateway")
