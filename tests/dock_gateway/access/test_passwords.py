"""Hashes at full cost, in a process of their own: threads that wait without end would keep this one from its end."""

import subprocess
import sys

import pytest

from tests.support.waiting import PATIENCE

START = """
import asyncio
from dock_gateway.access.passwords import Passwords

PASSWORD = "correct horse battery staple"

async def main():
"""
AT_ONCE = """
    several = [Passwords() for _ in range(4)]
    hashes = await asyncio.gather(*(each.hash(PASSWORD) for each in several))
    found = await asyncio.gather(*(each.verify(PASSWORD, hashed) for each, hashed in zip(several, hashes)))
    assert found == 4 * [(True, None)]
"""
AFTER_A_CANCELED_ONE = """
    passwords = Passwords()
    for _ in range(4):
        hanging_up = asyncio.create_task(passwords.hash(PASSWORD))
        await asyncio.sleep(0.01)
        hanging_up.cancel()
    assert await passwords.verify(PASSWORD, await passwords.hash(PASSWORD)) == (True, None)
"""


@pytest.mark.parametrize("body", [AT_ONCE, AFTER_A_CANCELED_ONE], ids=["at once", "after one that was canceled"])
def test_all_who_ask_are_answered(body: str) -> None:
    program = START + body + "\nasyncio.run(main())\n"
    subprocess.run([sys.executable, "-c", program], check=True, timeout=PATIENCE)
