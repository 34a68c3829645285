"""A camera of 640 x 480 at 10 Hz on `/benchmark/image`: `raw` (Image, bgr8) or `jpeg` (CompressedImage)."""

import sys
from contextlib import suppress

import numpy as np
import rclpy
import simplejpeg
from rclpy.executors import ExternalShutdownException
from rclpy.qos import QoSProfile
from sensor_msgs.msg import CompressedImage, Image

WIDTH, HEIGHT, RATE = 640, 480, 10.0


def pixels() -> np.ndarray:
    """Shades with noise, whose JPEG is about as long as that of a room."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    noise = np.random.default_rng(0).normal(0, 6, (HEIGHT, WIDTH, 3))
    return np.clip(np.stack((x % 256, y % 256, (x + y) % 256), -1) + noise, 0, 255).astype(np.uint8)


def main() -> None:
    """Publish until the end."""
    rclpy.init()
    node = rclpy.create_node("benchmark_camera")
    picture = np.ascontiguousarray(pixels())
    if sys.argv[1] == "raw":
        message = Image(width=WIDTH, height=HEIGHT, step=3 * WIDTH, encoding="bgr8", data=picture.tobytes())
    else:
        message = CompressedImage(format="jpeg", data=simplejpeg.encode_jpeg(picture))
    publisher = node.create_publisher(type(message), "/benchmark/image", QoSProfile(depth=1))
    node.create_timer(1 / RATE, lambda: publisher.publish(message))
    print("filming", flush=True)
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
