"""Cameras: nodes `/camera` and `/robot1/camera`, which publish pictures ten times a second.

`/front` is an Image in colour; `/robot1/back/image_raw` and its `compressed` form are 64 x 48 pixels, `/robot1/odd` has
an encoding that nobody knows. Each has a battery, which makes it a robot.
"""

import contextlib

import numpy as np
import rclpy
import simplejpeg
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import BatteryState, CompressedImage, Image

WIDTH, HEIGHT = 64, 48
PIXELS = np.full((HEIGHT, WIDTH, 3), (200, 30, 30), np.uint8)


def main() -> None:
    rclpy.init()
    jpeg = CompressedImage(format="jpeg", data=simplejpeg.encode_jpeg(PIXELS))
    raw = Image(width=WIDTH, height=HEIGHT, step=3 * WIDTH, encoding="rgb8", data=PIXELS.tobytes())
    odd = Image(width=1, height=1, step=1, encoding="odd", data=b"0")
    topics = {
        "/": {"front": raw, "battery_status": BatteryState()},
        "/robot1": {
            "back/image_raw": raw,
            "back/image_raw/compressed": jpeg,
            "odd": odd,
            "battery_status": BatteryState(),
        },
    }
    executor = SingleThreadedExecutor()
    for namespace, messages in topics.items():
        node = rclpy.create_node("camera", namespace=namespace)
        executor.add_node(node)
        for name, message in messages.items():
            publisher = node.create_publisher(type(message), name, qos_profile_sensor_data)
            node.create_timer(0.1, lambda publisher=publisher, message=message: publisher.publish(message))
    print("filming", flush=True)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        executor.spin()


if __name__ == "__main__":
    main()
