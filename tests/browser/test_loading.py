"""What a first visit transfers, and that what is on the screen does not move while the page loads."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser

from tests.browser.loading import first_visit
from tests.support.gateway import RunningGateway, running_gateway, running_program

MAX_BYTES = 300_000
MAX_SHIFT = 0.02


@pytest.fixture(scope="module")
def gateway(domain: int) -> Iterator[RunningGateway]:
    """A gateway and a simulated robot with its docking server."""
    with (
        running_program(domain, "dock_simulator"),
        running_program(domain, "docking_server"),
        running_gateway(domain) as gateway,
    ):
        gateway.wait_until_ready()
        yield gateway


@pytest.mark.parametrize("width", [1440, 768, 320])
def test_a_first_visit_is_small_and_does_not_move(browser: Browser, gateway: RunningGateway, width: int) -> None:
    visit = first_visit(browser, f"{gateway.url}/", width)
    assert visit.scripts > 100_000, "the scripts were not seen"
    assert visit.transferred < MAX_BYTES
    assert visit.shift < MAX_SHIFT, visit.moved
