"""The JSON shapes of cameras, for the OpenAPI document."""

from dock_gateway.http.schema import Schema


class CameraInfo(Schema):
    """A camera.

    `topic` and `type` are those of the pictures that come; if nobody watches it, those of the form that is tried first.
    `hint` says why its pictures cannot be shown, if someone watches it and they cannot.
    """

    name: str
    topic: str
    type: str
    hint: str | None


class CameraList(Schema):
    """The cameras of a robot, by name."""

    cameras: list[CameraInfo]
