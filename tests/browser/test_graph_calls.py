"""The graph page calls a service, sets a parameter and publishes a message: a real node takes them."""

from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.support.gateway import RunningGateway, running_gateway, running_service_node
from tests.support.processes import Process
from tests.support.waiting import wait_until


@pytest.fixture(scope="module")
def node(domain: int) -> Iterator[Process]:
    with running_service_node(domain) as process:
        yield process


@pytest.fixture(scope="module")
def gateway(domain: int, node: Process) -> Iterator[RunningGateway]:
    with ExitStack() as stack:
        lists = {
            "allow_services": "/robot1/echo",
            "allow_publish": "/robot1/chatter",
            "allow_parameters": "/robot1/base",
        }
        gateway = stack.enter_context(running_gateway(domain, **lists))
        wait_until(lambda: gateway.http.get("/services/robot1/echo").is_success, "the node")
        yield gateway


def select(page: Page, gateway: RunningGateway, thing: str) -> Locator:
    """Open the graph at a thing, and return its details."""
    page.goto(f"{gateway.url}/ui/graph?selected={thing}")
    return page.get_by_role("complementary", name="Details")


@pytest.mark.expect_page_errors
def test_what_the_settings_allow_is_done_and_the_rest_says_why_not(
    page: Page, gateway: RunningGateway, node: Process
) -> None:
    details = select(page, gateway, "service:/robot1/echo")
    details.get_by_role("switch", name="data").check()
    details.get_by_role("button", name="Call the service").click()
    page.get_by_role("dialog").get_by_role("button", name="Call the service").click()
    expect(details.get_by_test_id("message-tree")).to_contain_text("echoed")

    details = select(page, gateway, "topic:/robot1/chatter")
    details.get_by_role("textbox", name="data").fill("from the page")
    details.get_by_role("button", name="Publish the message").click()
    page.get_by_role("dialog").get_by_role("button", name="Publish the message").click()
    node.wait_for("heard from the page")
    expect(details).to_contain_text("It went to 1 subscriber.")

    details = select(page, gateway, "node:/robot1/base")
    details.get_by_role("button", name="Read the parameters").click()
    details.get_by_role("textbox", name="speed").fill("7")
    details.get_by_role("button", name="Set the parameter").click()
    expect(details).to_contain_text("expected 0 to 1 in steps of 0.1")
    details.get_by_role("textbox", name="speed").fill("0.7")
    details.get_by_role("button", name="Set the parameter").click()
    expect(details).to_contain_text("Set: speed.")
    parameters = gateway.http.get("/nodes/robot1/base/parameters").json()["parameters"]
    assert 0.7 in [parameter["value"] for parameter in parameters if parameter["name"] == "speed"]

    details = select(page, gateway, "topic:/robot1/cmd_vel")
    expect(details).to_contain_text("start it with --allow-publish '/robot1/cmd_vel' to allow that")
    expect(details.get_by_role("button", name="Publish the message")).to_have_count(0)
