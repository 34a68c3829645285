"""A gateway that asks for a login; users and tokens that are made on the command line."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from websockets.exceptions import ConnectionClosed

from tests.support.clients import HttpClient, connect
from tests.support.gateway import RunningGateway, running_gateway
from tests.support.processes import ForkedProcess
from tests.support.waiting import wait_until

PASSWORD = "correct horse battery staple"


class Done(NamedTuple):
    """How a command has ended, and what it printed, to either stream."""

    returncode: int
    output: str


class Site:
    """A database with users and tokens."""

    def __init__(self, folder: Path, database: str | None = None) -> None:
        self.database = database or f"sqlite:///{folder}/history.db"

    def run(self, *command: str, typed: str = "", **environment: str) -> Done:
        variables = {**os.environ, "DOCK_GATEWAY_DATABASE_URL": self.database, **environment}
        with ForkedProcess("dock-gateway", *command, env=variables, typed=typed) as process:
            return Done(process.wait(), process.output)

    def user(self, name: str, role: str, *limits: str) -> None:
        self._make("user", "create", name, "--role", role, *limits, typed=f"{PASSWORD}\n")

    def token(self, name: str, role: str, *limits: str) -> str:
        return self._make("token", "create", name, "--role", role, *limits).split()[-1]

    def _make(self, *command: str, typed: str = "") -> str:
        """Run a command, until the database of a busy machine answers; its output."""

        def made() -> Done | None:
            done = self.run(*command, typed=typed)
            assert done.returncode == 0 or "history_unavailable" in done.output, done.output
            return done if done.returncode == 0 else None

        return wait_until(made, "the database").output

    @contextmanager
    def gateway(self, domain: int, **settings: str) -> Iterator[RunningGateway]:
        # This machine is a proxy, so that a login can come from any address.
        trusted = {"trusted_proxies": "127.0.0.1"}
        settings = {"database_url": self.database, "authentication": "true", **trusted, **settings}
        with running_gateway(domain, **settings) as gateway:
            yield gateway


def bearer(secret: str) -> dict[str, str]:
    return {"Authorization": f"Bearer {secret}"}


def try_login(http: HttpClient, name: str, password: str = PASSWORD, address: str = "127.0.0.1") -> Any:
    """Log in as a browser at this address does; the answer."""
    body, headers = {"user": name, "password": password}, {"X-Forwarded-For": address}
    answer = http.post("/session", json=body, headers=headers)
    http.cookies.clear()
    return answer


def log_in(gateway: RunningGateway, name: str, password: str = PASSWORD) -> str:
    """Log in, once the database of a busy machine answers; the secret of the session."""
    answer = wait_until(lambda: try_login(gateway.http, name, password).raise_for_status(), f"the login of {name}")
    return str(answer.cookies["dock-gateway"])


def stream(gateway: RunningGateway, path: str, secret: str) -> Any:
    return connect(f"{gateway.url.replace('http', 'ws')}{path}", additional_headers=bearer(secret))


def ends_with(socket: Any) -> tuple[int, str]:
    """Read a WebSocket to its end; why it was closed."""
    with pytest.raises(ConnectionClosed) as closed:
        list(socket)
    assert closed.value.rcvd is not None
    return closed.value.rcvd.code, closed.value.rcvd.reason
