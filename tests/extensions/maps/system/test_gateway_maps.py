"""The map, the scan and the path of a robot: a real gateway, a real publisher, real DDS."""

import os
import signal
from collections.abc import Iterator
from typing import Any

import orjson
import pytest

from tests.support.clients import open_websocket
from tests.support.gateway import RunningGateway
from tests.support.installed import needs
from tests.support.processes import ForkedProcess, Process, ros_environment
from tests.support.waiting import PATIENCE, wait_until

pytestmark = pytest.mark.ros

ROBOT = "/robot1"
QUERY = {"robot": ROBOT}
SIZE = 200


@pytest.fixture(scope="module")
def robot(shared_domain: int, gateway: RunningGateway) -> Iterator[Process]:
    environment = ros_environment(shared_domain)
    with ForkedProcess("-m", "tests.extensions.maps.mapped_robot", "--namespace", ROBOT, env=environment) as process:
        process.wait_for("mapped")
        wait_until(lambda: gateway.http.get("/robots", params=QUERY).status_code == 200, "the robot")
        yield process


def subscribed(gateway: RunningGateway, topic: str) -> bool:
    readers = gateway.http.get(f"/graph/topics{topic}").json()["subscribers"]
    return any(reader["node"] == "/dock_gateway" for reader in readers)


def test_a_robot_on_its_map(gateway: RunningGateway, robot: Process) -> None:
    assert not subscribed(gateway, "/map")
    with gateway.stream(f"?robot={ROBOT}&include=map,maps,scan,path,scene") as stream:
        shown = stream.until(lambda event: event["type"] == "map" and event["map"]["odom"] is not None)["map"]
        assert (shown["topic"], shown["hint"]) == ("/map", None)
        assert shown["odom"] == {"x": 2.0, "y": 3.0, "theta": 1.5708}
        grid = shown["map"]
        assert (grid["frame"], grid["width"], grid["height"], grid["resolution"]) == ("map", SIZE, SIZE, 0.05)
        assert grid["origin"] == {"x": -2.5, "y": -2.5, "theta": 0.0}

        def sees_the_wall(event: dict[str, Any]) -> bool:
            return event["type"] == "scan" and event["scan"]["frame"] == "odom"

        points = stream.once_seen(sees_the_wall)["scan"]["points"]
        assert 300 < len(points) <= 360
        assert all(abs(x - 2.1) < 0.01 for x, _ in points)  # 1 m before the laser, which is 0.1 m before the robot
        path = stream.once_seen(lambda event: event["type"] == "path" and event["path"]["frame"] == "map")["path"]
        assert (path["points"][0], len(path["points"])) == ([2.0, 4.0], 360)
        maps = stream.once_seen(lambda event: event["type"] == "maps" and ROBOT in event["maps"])["maps"]
        assert maps[ROBOT]["map"] == grid
        scene = stream.once_seen(lambda event: event["type"] == "scene")["scene"]
        assert (scene["frame"], scene["odom"]) == ("odom", {"x": 0.0, "y": 0.0, "theta": 0.0})

        image = gateway.http.get("/map.png", params=QUERY).raise_for_status()
        assert image.headers["content-type"] == "image/png"
        tag = image.headers["etag"]
        assert tag.startswith(f'"{grid["revision"]}-')
        known = gateway.http.get("/map.png", params=QUERY, headers={"If-None-Match": tag})
        assert (known.status_code, known.headers["etag"]) == (304, tag)
        blue = gateway.http.get("/map.png", params={**QUERY, "free": "0000ff"}, headers={"If-None-Match": tag})
        assert blue.status_code == 200
        assert gateway.http.get("/map.png", params={**QUERY, "free": "blue"}).status_code == 422

        # Another map, and three that cannot be right.
        for words in (None, "1 values for 200 by 200 cells", "not within", "200000 by 200000 cells"):
            os.kill(robot.pid, signal.SIGUSR1)
            shown = stream.until(
                lambda event, words=words: (
                    event["type"] == "map"
                    and event["map"]["map"]["revision"] != grid["revision"]
                    and (words or "None") in str(event["map"]["hint"])
                )
            )["map"]
            assert shown["odom"] is not None
    newest = gateway.http.get("/map", params=QUERY).json()
    assert newest["map"]["revision"] == shown["map"]["revision"] != grid["revision"]
    wait_until(lambda: not subscribed(gateway, "/robot1/scan"), "that the scan is left")


@needs("rosbridge")
def test_a_robot_with_many_publishers_of_fixed_frames_whose_laser_misses_each_second_ray(
    gateway: RunningGateway, shared_domain: int
) -> None:
    """Also for one who comes later: another client has read the fixed frames before."""
    environment = ros_environment(shared_domain)
    options = ("--namespace", "/robot2", "--fixed", "120", "--odd")
    with (
        ForkedProcess("-m", "tests.extensions.maps.mapped_robot", *options, env=environment) as process,
        open_websocket(f"{gateway.url.replace('http', 'ws')}/rosbridge") as early,
    ):
        process.wait_for("mapped")
        wait_until(lambda: gateway.http.get("/robots", params={"robot": "/robot2"}).status_code == 200, "the robot")
        early.send(orjson.dumps({"op": "subscribe", "topic": "/robot2/tf_static", "type": "tf2_msgs/msg/TFMessage"}))
        frames: set[str] = set()
        while not {"/odom", "laser", "part119"} <= frames:
            message = orjson.loads(early.recv(PATIENCE))
            frames |= {each["child_frame_id"] for each in message["msg"]["transforms"]}
        with gateway.stream("?robot=/robot2&include=map,scan") as stream:
            shown = stream.until(lambda event: event["type"] == "map" and event["map"]["odom"] is not None)["map"]
            assert shown["odom"] == {"x": 2.0, "y": 3.0, "theta": 1.5708}
            assert shown["topic"] == "/map"  # its own is silent
            scan = stream.once_seen(lambda event: event["type"] == "scan" and event["scan"]["frame"] == "odom")["scan"]
            assert (len(scan["points"]), scan["hint"]) == (360, None)
            assert all(abs(x - 2.1) < 0.01 for x, _ in scan["points"])
