"""`dock-gateway doctor` beside a robot and a gateway."""

from typing import Any

import orjson
import pytest

from tests.support.gateway import RunningGateway, running_gateway, running_servers, running_talker
from tests.support.processes import ForkedProcess, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros


class Doctor:
    """Asks the doctor beside a gateway, again and again: on a busy machine, nodes are found late."""

    def __init__(self, domain: int, gateway: RunningGateway) -> None:
        self._domain = domain
        self._port = gateway.url.rpartition(":")[2]
        self.code = 0
        self.checks: dict[str, dict[str, Any]] = {}
        self.settings: list[str] = []

    def ask(self) -> None:
        environment = ros_environment(self._domain)
        arguments = ("doctor", "--json", "--wait", "2", "--port", self._port, "--database-url", "memory:")
        with ForkedProcess("dock-gateway", *arguments, env=environment) as process:
            self.code = process.wait()
            answer = orjson.loads(process.output)
        self.checks = {check["name"]: check for check in answer["checks"]}
        self.settings = answer["settings"]

    def sees(self, *words: str) -> bool:
        self.ask()
        return all(word in self.checks.get("robot /tb4", {"text": ""})["text"] for word in words)


def test_a_turtlebot_4_beside_a_gateway(domain: int) -> None:
    with (
        running_gateway(domain) as gateway,
        running_servers(domain, "--offer", "create3", "--robot", "/tb4"),
        running_talker(domain, "--topic", "/tb4/battery_state:sensor_msgs/msg/BatteryState:10"),
    ):
        doctor = Doctor(domain, gateway)
        wait_until(lambda: doctor.sees("docks with /tb4/dock", "battery on /tb4/battery_state"), "the robot")
        assert doctor.code == 0
        assert doctor.checks["port"]["text"] == f"a gateway runs at {gateway.url}"
        assert doctor.checks["ros"]["level"] == "ok"
        assert 'robots."/tb4".battery.topic = "/tb4/battery_state"' in doctor.settings
        assert "robot /" not in doctor.checks  # the gateway is none
