"""Topics of the right name and another type: they make no robot, and the gateway stays away from them."""

from collections.abc import Iterator
from typing import Any

import pytest
from geometry_msgs.msg import PoseStamped, Twist, Wrench
from rclpy.action import ActionServer
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Bool, String

from action_tutorials_interfaces.action import Fibonacci
from tests.support.gateway import LOW, RunningGateway, running_gateway
from tests.support.observer import Observer, ros_observer
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

BATTERY, VELOCITY, STOP, EMERGENCY = "/battery_status", "/cmd_vel", "/stop_latched", "/emergency_stop"
FOREIGN = "/fmu/out/battery_status"


@pytest.fixture
def px4(domain: int) -> Iterator[Observer]:
    with ros_observer(domain, "px4") as node:
        yield node


@pytest.fixture
def gateway(domain: int) -> Iterator[RunningGateway]:
    with running_gateway(domain, emergency_stop_topics=EMERGENCY) as gateway:
        yield gateway


def wrong_types(gateway: RunningGateway) -> dict[str, dict[str, Any]]:
    alerts = gateway.http.get("/alerts").raise_for_status().json()["alerts"]
    return {alert["robot"]: alert for alert in alerts if alert["kind"] == "wrong_topic_type"}


def robots(gateway: RunningGateway) -> list[str]:
    return [robot["name"] for robot in gateway.http.get("/robots").raise_for_status().json()["robots"]]


def nodes_at(observer: Observer, topic: str) -> set[str]:
    node = observer.node
    ends = [*node.get_publishers_info_by_topic(topic), *node.get_subscriptions_info_by_topic(topic)]
    return {end.node_name for end in ends}


def of_gateway(observer: Observer, topic: str) -> list[str]:
    """The types of the gateway's endpoints on a topic."""
    node = observer.node
    ends = [*node.get_publishers_info_by_topic(topic), *node.get_subscriptions_info_by_topic(topic)]
    return sorted(end.topic_type for end in ends if end.node_name == "dock_gateway")


def test_another_type_makes_no_robot(px4: Observer, gateway: RunningGateway) -> None:
    with px4.publishing(String(), FOREIGN, heard=False), px4.publishing(String(), "/a/_b/battery_status", heard=False):
        wait_until(lambda: "by /px4," in str(wrong_types(gateway).get("/fmu/out")), "the alert, with the node")
        alert = wrong_types(gateway)["/fmu/out"]
        assert alert["severity"] == "warning"
        for part in (FOREIGN, "std_msgs/msg/String", "sensor_msgs/msg/BatteryState", "/px4", "BATTERY_TOPIC"):
            assert part in alert["detail"]
        assert robots(gateway) == ["/"]
        assert wrong_types(gateway).keys() == {"/fmu/out"}
        assert not [topic for topic, _ in px4.node.get_topic_names_and_types() if topic.startswith("/fmu/out/s")]
        assert of_gateway(px4, FOREIGN) == []
    with px4.publishing(BatteryState(), "/fmu/out2/battery_status", heard=False):
        wait_until(lambda: "/fmu/out2" in robots(gateway), "the robot")


def test_the_gateway_leaves_topics_of_another_type_and_returns(
    domain: int, px4: Observer, gateway: RunningGateway
) -> None:
    wait_until(lambda: of_gateway(px4, BATTERY) == ["sensor_msgs/msg/BatteryState"] * 2, "the gateway at the topic")
    wait_until(lambda: of_gateway(px4, STOP), "the latch")
    topics = (BATTERY, STOP, EMERGENCY, VELOCITY)
    px4.call(lambda: [px4.node.create_publisher(String, topic, 10) for topic in topics[:3]])
    px4.record(Wrench, VELOCITY)
    wait_until(lambda: not any(of_gateway(px4, topic) for topic in topics), "the topics without the gateway")
    wait_until(lambda: "/" in wrong_types(gateway), "the alert")
    wait_until(lambda: wrong_types(gateway)["/"]["detail"].count("by /px4,") == 4, "all of them")
    alert = wrong_types(gateway)["/"]
    assert alert["severity"] == "critical"
    assert f"{EMERGENCY} is used as std_msgs/msg/String by /px4" in alert["detail"]
    refused = gateway.http.post("/battery", json=LOW)
    assert (refused.status_code, refused.json()["code"]) == (409, "wrong_topic_type")
    assert "no zero velocity" in alert["detail"]
    stopped = gateway.http.post("/stop", json={"by": "Ada"})
    assert (stopped.status_code, stopped.json()["code"]) == (503, "ros_unavailable")
    failed = {failure["code"]: failure["detail"] for failure in stopped.json()["failed"]}
    assert "geometry_msgs/msg/Wrench" in failed["publish_failed"]
    assert f"{STOP} is of another type" in failed["latch_not_published"]

    with ros_observer(domain, "driver") as driver:
        latched = driver.record(Bool, STOP)
        driver.record(Twist, VELOCITY)
        with driver.publishing(BatteryState(percentage=0.5), BATTERY):
            wait_until(lambda: gateway.http.get("/battery").json()["state"], "the battery")
        latched.wait_for(lambda message: message.data)
        wait_until(lambda: of_gateway(driver, VELOCITY), "the gateway at the velocity")
        assert gateway.http.post("/stop", json={"by": "Ada"}).status_code == 200
        assert wrong_types(gateway)["/"]["severity"] == "critical", "the emergency stop is still of another type"


def test_two_gateways_do_not_keep_each_other_there(domain: int, px4: Observer) -> None:
    with running_gateway(domain, node_name="first"), running_gateway(domain, node_name="second"):
        wait_until(lambda: len(px4.node.get_publishers_info_by_topic(BATTERY)) == 2, "both gateways")
        px4.call(lambda: px4.node.create_publisher(PoseStamped, BATTERY, 10))
        px4.record(Wrench, VELOCITY)
        wait_until(lambda: nodes_at(px4, BATTERY) == nodes_at(px4, VELOCITY) == {"px4"}, "both gateways away")


def test_an_action_of_the_right_name_is_used_with_the_type_of_its_server(
    px4: Observer, gateway: RunningGateway
) -> None:
    def server() -> dict[str, Any]:
        state: dict[str, Any] = gateway.http.get("/readyz").json()["action_server"]
        return state

    assert server()["action_type"] == "action_tutorials_interfaces/action/ConnectToChargingDock"
    served = px4.call(lambda: ActionServer(px4.node, Fibonacci, "/connect_to_charging_dock", lambda _: None))
    wait_until(lambda: server()["answering"], "the server")
    assert server()["action_type"] == "action_tutorials_interfaces/action/Fibonacci"
    px4.call(served.destroy)
