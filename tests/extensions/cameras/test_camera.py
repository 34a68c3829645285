"""Which cameras a robot has."""

from dock_gateway.core.graph import Endpoint, Quality, Topic
from dock_gateway.extensions.cameras.camera import COMPRESSED, IMAGE, Camera, Form, find_cameras

QUALITY = Quality("reliable", "volatile", "keep_last", 1, None, None, "automatic")


def topic(name: str, *kinds: str, heard: bool = False) -> Topic:
    endpoints = [Endpoint("/camera", kind, QUALITY) for kind in kinds]
    return Topic(name, [] if heard else endpoints, endpoints)


def camera(name: str, *forms: tuple[str, str]) -> Camera:
    return Camera(name, tuple(Form(*form) for form in forms))


def test_the_forms_of_a_camera_are_one_camera_the_cheapest_first() -> None:
    topics = [
        topic("/robot1/front/image_raw", IMAGE),
        topic("/robot1/front/image_raw/compressed", COMPRESSED),
        topic("/robot1/front/image_raw/compressedDepth", COMPRESSED),
        topic("/robot1/front/image_raw/zstd", COMPRESSED),
        topic("/robot1/back", IMAGE),
        topic("/robot1/depth/compressedDepth", COMPRESSED),
        topic("/robot1/usb", COMPRESSED),
        topic("/robot1/unheard", IMAGE, heard=True),
        topic("/robot1/_hidden", IMAGE),
        topic("/robot10/front", IMAGE),
    ]
    assert find_cameras("/robot1", topics, lambda _: True) == [
        camera("back", ("/robot1/back", IMAGE)),
        camera("depth", ("/robot1/depth/compressedDepth", COMPRESSED)),
        camera(
            "front/image_raw",
            ("/robot1/front/image_raw/compressed", COMPRESSED),
            ("/robot1/front/image_raw", IMAGE),
            ("/robot1/front/image_raw/compressedDepth", COMPRESSED),
        ),
        camera("usb", ("/robot1/usb", COMPRESSED)),
    ]


def test_of_a_camera_only_what_belongs_to_the_robot_and_its_reader() -> None:
    topics = [topic("/front", IMAGE), topic("/front/compressed", COMPRESSED), topic("/robot1/front", IMAGE)]
    found = find_cameras("/", topics, lambda name: name == "/front")
    assert found == [camera("front", ("/front", IMAGE))]
