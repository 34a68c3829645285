"""An extension of another distribution, examples/extension, installed from its wheel: all that it adds works."""

from collections.abc import Iterator
from pathlib import Path

import httpx2
import pytest
from nav_msgs.msg import Odometry

from dock_gateway.extension_list import OURS
from tests.support.distribution import install_example
from tests.support.gateway import RunningGateway, running_gateway
from tests.support.observer import Observer
from tests.support.processes import Process, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the wheel is installed."""
    return install_example(tmp_path_factory.mktemp("extension"))


@pytest.fixture
def settings(tmp_path: Path) -> dict[str, str]:
    database = f"sqlite:///{tmp_path}/history.db"
    return {"extensions": "odometer", "odometer_service_km": "0.002", "database_url": database}


@pytest.fixture
def drive(observer: Observer) -> Iterator[list[float]]:
    """A robot that drives, half a metre at a time."""
    publisher = observer.call(lambda: observer.node.create_publisher(Odometry, "/odom", 10))
    where = [0.0]

    def step() -> None:
        where[0] += 0.5
        message = Odometry()
        message.pose.pose.position.x = where[0]
        publisher.publish(message)

    timer = observer.call(lambda: observer.node.create_timer(0.1, step))
    yield where
    observer.call(timer.cancel)


def ask(gateway: RunningGateway, path: str) -> httpx2.Response:
    """Ask without the check of answers by the document of a gateway that does not have the extension."""
    return httpx2.get(f"{gateway.url}{path}", timeout=30)


def metres(gateway: RunningGateway) -> float:
    driven: float = ask(gateway, "/odometer").raise_for_status().json()["metres"]
    return driven


def test_it_reads_a_topic_and_adds_a_route_a_setting_an_alert_and_a_table(
    domain: int, site: Path, settings: dict[str, str], drive: list[float]
) -> None:
    with running_gateway(domain, "env", f"PYTHONPATH={site}", **settings) as gateway:
        wait_until(lambda: metres(gateway) > 2.0, "it has driven")
        alerts = wait_until(lambda: ask(gateway, "/alerts").json()["alerts"], "it is due")
        assert [(each["kind"], each["robot"], each["severity"]) for each in alerts] == [("service_due", "/", "warning")]
        document = gateway.http.get("/openapi.json").json()
        assert document["paths"]["/odometer"]["get"]["x-role"] == "viewer"
        assert "service_due" in document["components"]["schemas"]["AlertKind"]["enum"]
        assert ask(gateway, "/odometer?robot=/robot9").json()["code"] == "robot_not_found"
        driven = metres(gateway)
    with running_gateway(domain, "env", f"PYTHONPATH={site}", **settings) as gateway:
        assert metres(gateway) >= driven
    assert drive[0] >= driven


def test_its_card_is_listed_and_served(domain: int, site: Path, settings: dict[str, str]) -> None:
    with running_gateway(domain, "env", f"PYTHONPATH={site}", **settings) as gateway:
        listed = {each["name"]: each["card"] for each in gateway.http.get("/extensions").json()["extensions"]}
        assert listed["odometer"] == "/extensions/odometer/card.js"
        assert listed[OURS[0]] is None
        card = gateway.http.get(listed["odometer"])
        assert card.headers["content-type"].startswith("text/javascript")
        assert 'customElements.define("odometer-card"' in card.text
        assert gateway.http.get(f"/extensions/{OURS[0]}/card.js").json()["code"] == "extension_not_found"


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("nothing", "no installed distribution has an extension nothing"),
        (OURS[0], f"{OURS[0]} is one of the gateway's own"),
    ],
)
def test_one_that_is_not_there_keeps_the_gateway_from_starting(domain: int, name: str, sentence: str) -> None:
    environment = ros_environment(domain, DOCK_GATEWAY_EXTENSIONS=name, DOCK_GATEWAY_PORT="0")
    with Process("dock-gateway", "serve", env=environment) as process:
        assert sentence in process.wait_for("extensions: ")
