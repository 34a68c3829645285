"""A gateway that asks for tokens, and tokens that are made on the command line."""

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tests.support.clients import connect
from tests.support.gateway import RunningGateway, running_gateway
from tests.support.processes import BIN


class Site:
    """A database with tokens."""

    def __init__(self, folder: Path) -> None:
        self.database = f"sqlite:///{folder}/history.db"

    def run(self, *command: str, **environment: str) -> subprocess.CompletedProcess[str]:
        variables = {**os.environ, "DOCK_GATEWAY_DATABASE_URL": self.database, **environment}
        return subprocess.run(
            [BIN / "dock-gateway", *command], env=variables, capture_output=True, text=True, check=False
        )

    def token(self, name: str, role: str, *limits: str) -> str:
        created = self.run("token", "create", name, "--role", role, *limits)
        assert created.returncode == 0, created.stderr
        return created.stdout.strip()

    @contextmanager
    def gateway(self, domain: int) -> Iterator[RunningGateway]:
        with running_gateway(domain, database_url=self.database, authentication="true") as gateway:
            yield gateway


def bearer(secret: str) -> dict[str, str]:
    return {"Authorization": f"Bearer {secret}"}


def stream(gateway: RunningGateway, path: str, secret: str) -> Any:
    return connect(f"{gateway.url.replace('http', 'ws')}{path}", additional_headers=bearer(secret))
