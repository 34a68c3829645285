"""The card of an extension of another distribution is on a robot's page, under the page's content security policy."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Page, expect

from tests.support.distribution import install_example
from tests.support.gateway import RunningGateway, running_dock_server, running_gateway


@pytest.fixture(scope="module")
def gateway(domain: int, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningGateway]:
    """A gateway with the odometer of examples/extension."""
    site = install_example(tmp_path_factory.mktemp("extension"))
    with (
        running_dock_server(domain),
        running_gateway(domain, "env", f"PYTHONPATH={site}", extensions="odometer") as gateway,
    ):
        gateway.wait_until_ready()
        yield gateway


def test_a_robots_page_has_its_card(page: Page) -> None:
    card = page.get_by_role("region", name="Odometer")
    expect(card).to_contain_text("0.000 km")


def test_other_pages_have_none_of_it(page: Page) -> None:
    page.get_by_role("navigation", name="Pages").get_by_role("link", name="Goals").click()
    expect(page.get_by_role("region", name="Odometer")).to_have_count(0)
