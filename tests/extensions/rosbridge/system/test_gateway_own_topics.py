"""The topics that the gateway itself needs have their type from their name: no client can take them away."""

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Bool, String

from tests.extensions.rosbridge.door import client_of
from tests.support.gateway import RunningGateway, running_gateway, running_program
from tests.support.observer import Observer
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
STRING = "std_msgs/msg/String"
NEEDED = [
    "/rob7/stop_latched",
    "/rob7/emergency_stop",
    "/rob7/cmd_vel",
    "/rob7/battery_status",
    "/rob7/initialpose",
    "/tf",
    "/tf_static",
]


def robots(gateway: RunningGateway) -> list[str]:
    return [robot["name"] for robot in gateway.http.get("/robots").raise_for_status().json()["robots"]]


def test_a_stop_is_heard_although_a_viewer_asked_for_its_topic_first(domain: int, observer: Observer) -> None:
    with running_gateway(domain, emergency_stop_topics="emergency_stop") as gateway, client_of(gateway) as viewer:
        for topic in NEEDED:
            viewer.send("subscribe", topic=topic, type=STRING)
            assert topic in viewer.error("the gateway uses")
        viewer.send("subscribe", topic="/rob7/stop_latched", type="std_msgs/Bool")
        viewer.send("subscribe", topic="/rob7/battery_status", type="sensor_msgs/BatteryState")
        latch = observer.record(Bool, "/rob7/stop_latched", LATCHED)
        with observer.publishing(BatteryState(), "/rob7/battery_status", heard=False):
            wait_until(lambda: "/rob7" in robots(gateway), "the robot")
            report = gateway.http.post("/stop?robot=/rob7").raise_for_status().json()
            assert (report["stopped"], report["failed"]) == (["/rob7"], [])
            latch.wait_for(lambda message: message.data)
            viewer.until("publish", topic="/rob7/stop_latched", msg={"data": True})


def test_a_topic_of_another_type_is_read_as_its_publisher_has_it(domain: int, observer: Observer) -> None:
    """As that of PX4; but not one that nothing but the gateway publishes on."""
    with running_gateway(domain) as gateway, client_of(gateway) as viewer:
        with observer.publishing(String(data="full"), "/fmu/out/battery_status", heard=False):
            wait_until(lambda: gateway.http.get("/graph/topics/fmu/out/battery_status").status_code == 200, "the topic")
            viewer.send("subscribe", topic="/fmu/out/battery_status")
            assert viewer.until("publish", topic="/fmu/out/battery_status")["msg"] == {"data": "full"}
        with observer.publishing(String(), "/rob8/stop_latched", heard=False):
            wait_until(lambda: gateway.http.get("/graph/topics/rob8/stop_latched").status_code == 200, "the topic")
            viewer.send("subscribe", topic="/rob8/stop_latched")
            viewer.error("the gateway uses /rob8/stop_latched as std_msgs/msg/Bool, not as std_msgs/msg/String")


def test_an_action_is_there_although_a_viewer_asked_for_its_topics_first(domain: int) -> None:
    with running_gateway(domain) as gateway, client_of(gateway) as viewer:
        for part, kind in (
            ("feedback", STRING),
            ("status", STRING),
            ("feedback", "nav2_msgs/action/Spin_FeedbackMessage"),
        ):
            viewer.send("subscribe", topic=f"/fibonacci/_action/{part}", type=kind)
            viewer.error("an action that has a server")
        with running_program(domain, "fibonacci_action_server"):
            wait_until(lambda: gateway.http.get("/actions/fibonacci").status_code == 200, "the action")
            answer = gateway.http.post("/actions/fibonacci/goals", json={"order": 2}, headers={"Prefer": "wait=60"})
            assert (answer.status_code, answer.json()["status"]) == (200, "succeeded")


@pytest.mark.parametrize("part", ["status", "feedback"])
def test_an_action_is_there_although_another_node_lied_about_its_topics_first(
    domain: int, observer: Observer, part: str
) -> None:
    topic = f"/fibonacci/_action/{part}"
    with (
        running_gateway(domain) as gateway,
        client_of(gateway) as viewer,
        observer.publishing(String(), topic, heard=False),
    ):
        wait_until(lambda: gateway.http.get(f"/graph/topics{topic}").status_code == 200, "the topic")
        viewer.send("subscribe", topic=topic)
        viewer.error(f"the gateway uses {topic} as ")
        with running_program(domain, "fibonacci_action_server"):
            wait_until(lambda: gateway.http.get("/actions/fibonacci").status_code == 200, "the action")
            answer = gateway.http.post("/actions/fibonacci/goals", json={"order": 2}, headers={"Prefer": "wait=60"})
            assert (answer.status_code, answer.json()["status"]) == (200, "succeeded")
