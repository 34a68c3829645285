"""Cameras: nodes `/camera` and `/robot1/camera`, which publish pictures ten times a second.

`/front` is an Image in colour; `/robot1/back/image_raw` and its `compressed` form are 64 x 48 pixels, `/robot1/odd` has
an encoding that nobody knows. Each has a battery, which makes it a robot.

`/robot1/depth/image_raw` is a depth of 1 m on the left and 4 m on the right. Its `compressed` form is advertised and
stays silent until SIGUSR1; then the other one does. `/robot1/png/compressed` is the same depth in a PNG, and memory
follows each JPEG of `/robot1/esp/compressed`.
"""

import contextlib
import signal
from typing import Any

import numpy as np
import rclpy
import simplejpeg
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.publisher import Publisher
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import BatteryState, CompressedImage, Image

from tests.support.pictures import encode_png

WIDTH, HEIGHT = 64, 48
DEPTH = np.full((HEIGHT, WIDTH), 1000, np.uint16)
DEPTH[:, WIDTH // 2 :] = 4000
PIXELS = np.full((HEIGHT, WIDTH, 3), (200, 30, 30), np.uint8)


def main() -> None:
    rclpy.init()
    jpeg = CompressedImage(format="jpeg", data=simplejpeg.encode_jpeg(PIXELS))
    raw = Image(width=WIDTH, height=HEIGHT, step=3 * WIDTH, encoding="rgb8", data=PIXELS.tobytes())
    esp = CompressedImage(format="jpeg", data=bytes(jpeg.data) + b"\xff\xd8" + 142 * b"\xa5")
    depth = Image(width=WIDTH, height=HEIGHT, step=2 * WIDTH, encoding="16UC1", data=DEPTH.tobytes())
    png = CompressedImage(format="16UC1; png compressed", data=encode_png(DEPTH, (4, 3, 2, 1, 0)))
    odd = Image(width=1, height=1, step=1, encoding="odd", data=b"0")
    topics = {
        "/": {"front": raw, "battery_status": BatteryState()},
        "/robot1": {
            "back/image_raw": raw,
            "back/image_raw/compressed": jpeg,
            "odd": odd,
            "depth/image_raw": depth,
            "depth/image_raw/compressed": png,
            "png/compressed": png,
            "esp/compressed": esp,
            "battery_status": BatteryState(),
        },
    }
    silent = ["/robot1/depth/image_raw/compressed", "/robot1/depth/image_raw"]
    executor = SingleThreadedExecutor()
    for namespace, messages in topics.items():
        node = rclpy.create_node("camera", namespace=namespace)
        executor.add_node(node)
        for name, message in messages.items():
            publisher = node.create_publisher(type(message), name, qos_profile_sensor_data)

            def publish(publisher: Publisher = publisher, message: Any = message) -> None:
                if publisher.topic_name != silent[0]:
                    publisher.publish(message)

            node.create_timer(0.1, publish)
    signal.signal(signal.SIGUSR1, lambda *_: silent.reverse())
    print("filming", flush=True)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        executor.spin()


if __name__ == "__main__":
    main()
