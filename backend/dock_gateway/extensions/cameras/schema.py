"""The JSON shapes of cameras, for the OpenAPI document."""

from dock_gateway.http.schema import Schema


class CameraInfo(Schema):
    """A camera.

    `topic` and `type` are those of the pictures that are shown; without a viewer, of the form that is tried first.
    `hint` is the reason if a viewer cannot be shown its pictures.
    """

    name: str
    topic: str
    type: str
    hint: str | None


class CameraList(Schema):
    """The cameras of a robot, by name."""

    cameras: list[CameraInfo]
