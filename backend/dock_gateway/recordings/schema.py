"""The JSON shapes of recordings."""

from dock_gateway.http.schema import Schema


class GoalRecording(Schema):
    """Whether a goal has a recording at this gateway: its size in bytes, or `why_none`, or it is still `running`.

    `picture`: whether it has a picture of a camera, for the thumbnail.
    """

    size: int | None
    why_none: str | None
    running: bool
    picture: bool
