"""How long tests wait for what must come: long, as a machine may be busy, and what comes at once costs no time."""

import asyncio
import time
from collections.abc import Callable
from http import HTTPStatus
from typing import TypeVar

import httpx2

PATIENCE = 120.0
T = TypeVar("T")


def wait_until(condition: Callable[[], T], what: str, timeout: float = PATIENCE) -> T:
    """Poll until the condition holds (is true) and return its value; fail after `timeout` seconds.

    While a gateway answers 503, as it does for moments on a busy machine, the condition does not hold.
    """
    deadline = time.monotonic() + timeout
    while True:
        try:
            if value := condition():
                return value
        except httpx2.HTTPStatusError as error:
            if error.response.status_code != HTTPStatus.SERVICE_UNAVAILABLE or time.monotonic() > deadline:
                raise
        if time.monotonic() > deadline:
            raise AssertionError(f"not seen within {timeout:g} s: {what}")
        time.sleep(0.02)


async def until(holds: Callable[[], bool], timeout: float = PATIENCE) -> None:
    """Wait until something holds."""
    deadline = time.monotonic() + timeout
    while not holds():
        assert time.monotonic() < deadline, "it never came to be"
        await asyncio.sleep(0.02)
