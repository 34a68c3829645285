"""Any action by clicking: a form of its goal, sent, watched and canceled, against real action servers."""

import re
from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.axe import find_violations
from tests.browser.width import expect_no_sideways_scrolling
from tests.support.gateway import CHARGING, LOW, RunningGateway, running_gateway, running_program
from tests.support.waiting import wait_until

COUNTED = "/robot1/fibonacci"
DOCK = "/connect_to_charging_dock"


@pytest.fixture(scope="module")
def gateway(domain: int) -> Iterator[RunningGateway]:
    """A gateway with a docking server, and one that counts in a namespace, quickly."""
    with ExitStack() as stack:
        counting = ("-r", "__ns:=/robot1", "-p", "step_period:=0.2")
        stack.enter_context(running_program(domain, "fibonacci_action_server", *counting))
        stack.enter_context(running_program(domain, "connect_to_charging_dock_server"))
        gateway = stack.enter_context(running_gateway(domain))
        gateway.wait_until_ready()
        wait_until(lambda: gateway.http.get(f"/actions{COUNTED}").is_success, "the Fibonacci server")
        yield gateway


def show(page: Page, gateway: RunningGateway, name: str = "") -> None:
    """Open the list of actions, or one of them."""
    page.goto(f"{gateway.url}/ui/actions{name}")
    expect(page.get_by_test_id("connection")).to_have_text("live")


def press(page: Page, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def expect_status(page: Page, status: str) -> None:
    expect(page.get_by_test_id("goal-status")).to_have_text(status)


def command(page: Page) -> Locator:
    """The command line that sends the goal."""
    return page.locator("code").filter(has_text="curl")


def newest(gateway: RunningGateway, action: str) -> dict[str, object]:
    """What the newest goal on an action asks for."""
    goals = gateway.http.get(f"/actions{action}/goals").raise_for_status().json()["goals"]
    asked: dict[str, object] = goals[0]["goal"]
    return asked


def test_from_the_list_to_a_sequence_that_grows(page: Page, gateway: RunningGateway) -> None:
    show(page, gateway)
    row = page.get_by_role("row").filter(has_text=COUNTED)
    expect(row).to_contain_text("answering")
    row.get_by_role("link", name=COUNTED).click()
    expect(page).to_have_url(f"{gateway.url}/ui/actions{COUNTED}")
    page.get_by_label("order").fill("12")
    expect(command(page)).to_contain_text(f"{gateway.url}/actions{COUNTED}/goals")
    expect(command(page)).to_contain_text("""-d '{"order": 12}'""")
    press(page, "Send goal")
    expect(page.get_by_test_id("sent")).to_contain_text("Sent: the action server took goal")
    partial = page.get_by_role("list", name="partial_sequence").get_by_role("listitem")
    expect(partial.nth(3)).to_have_text("2")
    expect_status(page, "succeeded")
    expect(page.get_by_role("list", name="sequence", exact=True).get_by_role("listitem")).to_have_text(
        ["0", "1", "1", "2", "3", "5", "8", "13", "21", "34", "55", "89", "144"]
    )
    page.get_by_test_id("sent").get_by_role("link").click()
    expect(page).to_have_url(re.compile(r"/ui/goals/[0-9a-f-]{36}$"))


def test_cancel(page: Page, gateway: RunningGateway) -> None:
    show(page, gateway, COUNTED)
    page.get_by_label("order").fill("46")
    press(page, "Send goal")
    expect_status(page, "executing")
    press(page, "Cancel")
    expect_status(page, "canceled")


def test_a_goal_of_someone_else_is_watched_and_filled_in_again(page: Page, gateway: RunningGateway) -> None:
    show(page, gateway, COUNTED)
    gateway.http.post(f"/actions{COUNTED}/goals", json={"order": 21}).raise_for_status()
    expect_status(page, "executing")
    row = page.get_by_role("row").filter(has_text='{"order": 21}').first
    row.get_by_role("button", name="Reuse").click()
    expect(page.get_by_label("order")).to_have_value("21")
    press(page, "Cancel")
    expect_status(page, "canceled")


def test_a_robot_moves_only_after_a_question(page: Page, gateway: RunningGateway) -> None:
    gateway.publish(LOW)
    show(page, gateway, DOCK)
    page.get_by_label("power_supply_status").select_option("FULL (4)")
    page.get_by_label("voltage in V", exact=True).fill("12.6")
    press(page, "Send goal …")
    question = page.get_by_role("dialog", name="Send this goal?")
    expect(question).to_contain_text('{"desired_battery_state": {"voltage": 12.6, "power_supply_status": 4}}')
    question.get_by_role("button", name="Do not send").click()
    expect(question).to_be_hidden()
    assert gateway.http.get("/dock").json()["goals"] == []
    page.get_by_label("power_supply_status").select_option("CHARGING (1)")
    press(page, "Send goal …")
    question.get_by_role("button", name="Send the goal").click()
    expect_status(page, "executing")
    expect(page.get_by_test_id("message-tree")).to_contain_text("2.16 V")
    gateway.publish(CHARGING)
    expect_status(page, "succeeded")
    asked = gateway.http.get("/dock").json()["goals"][0]["goal"]["desired_battery_state"]
    assert (asked["voltage"], asked["power_supply_status"]) == (12.6, 1)
    # Of what is kept in full, the row has what was set.
    row = page.get_by_role("row").filter(has_text='{"voltage": 12.6, "power_supply_status": 1}')
    expect(row.get_by_role("button", name="Reuse")).to_be_visible()


@pytest.mark.expect_page_errors  # the browser logs the 422
def test_what_the_gateway_refuses_is_said_at_the_field(page: Page, gateway: RunningGateway) -> None:
    show(page, gateway, COUNTED)
    page.get_by_text("JSON", exact=True).click()
    # The form knows what the gateway takes, so that what it sends is changed on the way.
    page.route("**/goals", lambda route: route.continue_(post_data='{"order": 3.5}'))
    page.get_by_label("Goal message as JSON").fill('{"order": 3}')
    press(page, "Send goal")
    expect(page.get_by_text("Send goal did not work: a value is not valid")).to_be_visible()
    expect(page.get_by_role("listitem").filter(has_text="order: expected int32")).to_contain_text("got 3.5")
    page.get_by_text("Form", exact=True).click()
    order = page.get_by_label("order")
    expect(order).to_have_value("3")
    order.fill("three")
    press(page, "Send goal")
    expect(order).to_be_focused()
    expect(page.get_by_text("expected a whole number from")).to_be_visible()


def test_json_is_sent_as_it_is_typed(page: Page, gateway: RunningGateway) -> None:
    show(page, gateway, COUNTED)
    page.get_by_text("JSON", exact=True).click()
    page.get_by_label("Goal message as JSON").fill('{\n  "order":   4\n}')
    with page.expect_request("**/goals") as request:
        press(page, "Send goal")
    assert request.value.post_data == '{\n  "order":   4\n}'
    expect_status(page, "succeeded")
    assert newest(gateway, COUNTED) == {"order": 4}


def test_json_is_edited_with_its_errors_marked(page: Page, gateway: RunningGateway) -> None:
    show(page, gateway, COUNTED)
    page.get_by_text("JSON", exact=True).click()
    editor = page.get_by_role("textbox", name="Goal message as JSON")
    expect(editor).to_be_editable()
    expect(editor).to_have_accessible_description(re.compile("^Fields that are left out"))
    page.get_by_text("Goal message as JSON").click()
    expect(editor).to_be_focused()
    page.keyboard.press("Control+A")
    page.keyboard.type('{\n"order": "many",\n"ordre": 3')
    expect(editor).to_have_attribute("aria-invalid", "true")
    expect(page.locator(".cm-lintPoint-error")).to_be_attached()
    page.keyboard.type("}")
    marks = page.locator(".cm-lintRange-error")
    expect(page.get_by_role("listitem").filter(has_text="ordre: there is no such field")).to_be_visible()
    assert "".join(marks.all_text_contents()) == '"order": "many""ordre": 3'
    for scheme in ("light", "dark"):
        page.evaluate("(scheme) => document.documentElement.dataset.mantineColorScheme = scheme", scheme)
        assert find_violations(page) == []
    page.keyboard.press("Control+Z")
    expect(editor).not_to_contain_text("ordre")
    page.keyboard.press("Tab")
    expect(page.get_by_role("button", name="Send goal", exact=True)).to_be_focused()
    page.keyboard.press("Shift+Tab")
    expect(editor).to_be_focused()
    page.keyboard.press("Escape")
    page.keyboard.press("Escape")
    wait_until(lambda: gateway.http.get("/stop").json()["latched"], "the stop")


def test_by_keyboard_alone(page: Page, gateway: RunningGateway) -> None:
    show(page, gateway, COUNTED)
    order = page.get_by_label("order")
    expect(order).to_be_visible()
    page.get_by_role("link", name="All actions").focus()
    for _ in range(10):
        if order.evaluate("(element) => element === document.activeElement"):
            break
        page.keyboard.press("Tab")
    expect(order).to_be_focused()
    page.keyboard.press("Control+A")
    page.keyboard.type("40")
    page.keyboard.press("Enter")
    expect_status(page, "executing")
    page.keyboard.press("Escape")
    cancel = page.get_by_role("button", name="Cancel", exact=True)
    for _ in range(20):
        if cancel.evaluate("(element) => element === document.activeElement"):
            break
        page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    expect_status(page, "canceled")


def test_a_server_that_goes_takes_no_form_with_it(page: Page, gateway: RunningGateway, domain: int) -> None:
    name = "/robot2/fibonacci"
    show(page, gateway, name)
    expect(page.get_by_text(f"No action server for {name}")).to_be_visible()
    with running_program(domain, "fibonacci_action_server", "-r", "__ns:=/robot2"):
        page.get_by_label("order").fill("17")
        expect(page.get_by_role("button", name="Send goal")).to_be_enabled()
    expect(page.get_by_text("No action server for this action")).to_be_visible()
    expect(page.get_by_label("order")).to_have_value("17")
    expect(page.get_by_role("button", name="Send goal")).to_be_disabled()


def test_accessibility(page: Page, gateway: RunningGateway) -> None:
    gateway.publish(LOW)
    show(page, gateway)
    expect(page.get_by_role("row").filter(has_text=COUNTED)).to_be_visible()
    assert find_violations(page) == []
    show(page, gateway, COUNTED)
    page.get_by_label("order").fill("46")
    press(page, "Send goal")
    expect(page.get_by_role("list", name="partial_sequence")).to_be_visible()
    page.get_by_label("order").fill("many")
    assert find_violations(page) == []
    show(page, gateway, DOCK)
    page.locator("form summary").filter(has_text="std_msgs/Header").click()
    page.get_by_label("voltage in V", exact=True).fill("much")
    expect(page.get_by_text("1 not valid")).to_be_visible()
    assert find_violations(page) == []
    page.get_by_label("voltage in V", exact=True).fill("")
    press(page, "Send goal …")
    expect(page.get_by_role("dialog", name="Send this goal?")).to_be_visible()
    assert find_violations(page) == []


@pytest.mark.parametrize("name", ["", COUNTED, DOCK])
def test_a_phone(page: Page, gateway: RunningGateway, name: str) -> None:
    page.set_viewport_size({"width": 320, "height": 800})
    show(page, gateway, name)
    expect(
        page.get_by_role("link", name=COUNTED).or_(page.get_by_role("button", name=re.compile("^Send")))
    ).to_be_visible()
    expect_no_sideways_scrolling(page)
