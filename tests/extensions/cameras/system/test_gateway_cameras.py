"""Pictures of cameras: real gateway, real publishers, real DDS."""

import os
import signal
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import httpx2
import pytest
import simplejpeg

from tests.support.access import Site, bearer
from tests.support.camera_node import HEIGHT, WIDTH
from tests.support.gateway import RunningGateway
from tests.support.processes import ForkedProcess, Process, ros_environment
from tests.support.waiting import wait_until

pytestmark = pytest.mark.ros

COMPRESSED = "/robot1/back/image_raw/compressed"


def parts(answer: httpx2.Response) -> Iterator[bytes]:
    """The pictures of a stream."""
    received = b""
    for chunk in answer.iter_bytes():
        received += chunk
        while b"\r\n--picture\r\n" in received:
            part, _, received = received.partition(b"\r\n--picture\r\n")
            yield part.partition(b"\r\n\r\n")[2]


def test_cameras_of_two_robots(domain: int, tmp_path: Path) -> None:
    site = Site(tmp_path)
    viewer, limited = site.token("eve", "viewer"), site.token("mallory", "viewer", "--topic", "/robot1/back/*")
    with ExitStack() as stack:
        gateway = stack.enter_context(site.gateway(domain))
        http = gateway.http
        http.headers.update(bearer(viewer))
        films = stack.enter_context(ForkedProcess("-m", "tests.support.camera_node", env=ros_environment(domain)))
        films.wait_for("filming")

        def cameras(robot: str, **options: Any) -> dict[str, str | None]:
            found = http.get("/cameras", params={"robot": robot}, **options)
            return {each["name"]: each["type"] for each in found.json().get("cameras", ())}

        image, compressed = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
        everything = {
            "back/image_raw": compressed,
            "depth/image_raw": compressed,
            "esp": compressed,
            "odd": image,
            "png": compressed,
        }
        wait_until(lambda: cameras("/robot1") == everything, "the cameras of /robot1")
        wait_until(lambda: cameras("/") == {"front": image}, "the camera of /")
        assert cameras("/robot1", headers=bearer(limited)) == {"back/image_raw": compressed}

        look_at_pictures(gateway)
        look_at_depths(http, films)
        picture = http.get("/cameras/esp/image?robot=/robot1").raise_for_status()
        assert picture.content.endswith(b"\xff\xd9")
        refused = http.get("/cameras/odd/image?robot=/robot1", headers=bearer(limited))
        assert refused.json()["code"] == "not_allowed"
        unreadable = http.get("/cameras/odd/stream?robot=/robot1")
        assert unreadable.json()["detail"].startswith("/robot1/odd cannot be shown: the encoding 'odd' is not shown")
        assert http.get("/cameras/none/image?robot=/robot1").json()["code"] == "camera_not_found"

        with http.stream("GET", "/cameras/back/image_raw/stream?robot=/robot1", headers=bearer(limited)) as stream:
            pictures = parts(stream)
            assert next(pictures)
            assert site.run("token", "delete", "mallory").returncode == 0
            for _ in pictures:  # to its end
                pass
        wait_until(lambda: not readers(http), "it is left")


def look_at_pictures(gateway: RunningGateway) -> None:
    """Viewers share one subscription; what is too wide is scaled down; the last one to leave ends it."""
    http = gateway.http
    picture = http.get("/cameras/front/image?robot=/")
    assert picture.headers["content-type"] == "image/jpeg"
    assert simplejpeg.decode_jpeg_header(picture.content)[:2] == (HEIGHT, WIDTH)
    small = http.get("/cameras/front/image?robot=/&max_width=16")
    assert simplejpeg.decode_jpeg_header(small.content)[:2] == (HEIGHT // 4, WIDTH // 4)

    path = "/cameras/back/image_raw/stream?robot=/robot1"
    with http.stream("GET", path) as one, http.stream("GET", f"{path}&max_rate=1&max_width=32") as two:
        assert one.headers["content-type"] == "multipart/x-mixed-replace; boundary=picture"
        pictures = parts(one)
        assert next(pictures) == next(pictures)
        assert simplejpeg.decode_jpeg_header(next(parts(two)))[:2] == (HEIGHT // 2, WIDTH // 2)
        assert readers(http) == ["/dock_gateway"]
    wait_until(lambda: not readers(http), "it is left")


def look_at_depths(http: httpx2.Client, films: Process) -> None:
    """The form that speaks is shown, and no other one is subscribed to, also when it falls silent later."""
    raw, compressed = "/robot1/depth/image_raw", "/robot1/depth/image_raw/compressed"
    with http.stream("GET", "/cameras/depth/image_raw/stream?robot=/robot1") as stream:
        assert stream.status_code == 200
        pictures = parts(stream)
        for silent, speaking in ((compressed, raw), (raw, compressed)):
            wait_until(lambda silent=silent: next(pictures) and not readers(http, silent), "one subscription")
            assert readers(http, speaking) == ["/dock_gateway"]
            check_depth(next(pictures))
            os.kill(films.pid, signal.SIGUSR1)
    check_depth(http.get("/cameras/png/image?robot=/robot1").raise_for_status().content)


def check_depth(jpeg: bytes) -> None:
    """1 m on the left, 4 m on the right."""
    pixels = simplejpeg.decode_jpeg(jpeg)
    assert pixels.shape == (HEIGHT, WIDTH, 3)
    assert (int(pixels[9, 9, 0]), int(pixels[9, -9, 0])) == (pytest.approx(229, abs=3), pytest.approx(153, abs=3))


def readers(http: Any, topic: str = COMPRESSED) -> list[str]:
    return [each["node"] for each in http.get(f"/graph/topics{topic}").json()["subscribers"]]
