"""The operations of rosbridge v2 as a client sends them, and the messages that it is sent. No ROS, no socket."""

from base64 import b64encode
from datetime import datetime
from enum import IntEnum
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from dock_gateway.core.errors import FieldError, GatewayError, InvalidField, MalformedRequest, NotInstalled
from dock_gateway.core.goal import GoalStatus, encode
from dock_gateway.core.json_text import decode_json
from dock_gateway.stop.order import STOP_SERVICE, is_stop_service, says

Json = dict[str, Any]
Identity = str | int | None

# Characters of an id: clients put the name of an action or a service into it.
MAX_ID = 1000
# Characters of a fragment; a message of a million in pieces of one would be a flood.
FragmentSize = Annotated[int, Field(ge=100)] | None
Name = Annotated[str, Field(min_length=1, max_length=300)]


class Level(IntEnum):
    """The levels of status messages. A client is sent those up to its own."""

    none = 0
    error = 1
    warning = 2
    info = 3


class Compression(IntEnum):
    """The compressions of a subscription. If a client has several of one topic, the greatest is used."""

    none = 0
    png = 1
    cbor = 2
    cbor_raw = 3

    @classmethod
    def named(cls, name: str | None) -> "Compression":
        """Return a compression by its name in the protocol."""
        return cls[(name or "none").replace("-", "_")]


class RosbridgeOperation(BaseModel):
    """An operation. Fields that are not known are ignored, as rosbridge does."""

    model_config = ConfigDict(extra="ignore")


class Subscribe(RosbridgeOperation):
    """Send the messages of a topic.

    Attributes:
        topic: Its name.
        type: Its type, such as `std_msgs/msg/String` or `std_msgs/String`. Needed if no node has the topic yet.
        throttle_rate: Minimum milliseconds between two messages.
        queue_length: Number of messages that wait for a client that is slow, or for `throttle_rate`.
        fragment_size: Maximum number of characters of a message; longer ones come in pieces.
        compression: How messages are encoded.
    """

    topic: Name
    type: Name | None = None
    throttle_rate: Annotated[float, Field(ge=0, le=86_400_000)] = 0
    queue_length: Annotated[int, Field(ge=0)] = 0
    fragment_size: FragmentSize = None
    compression: Literal["none", "png", "cbor", "cbor-raw"] | None = None


class Unsubscribe(RosbridgeOperation):
    """Send no more messages of a topic."""

    topic: Name


class SendActionGoal(RosbridgeOperation):
    """Send a goal."""

    action: Name
    action_type: str | None = None
    args: Any = None
    feedback: bool = False
    fragment_size: FragmentSize = None


class CancelActionGoal(RosbridgeOperation):
    """Cancel a goal by the `id` of its `send_action_goal`."""

    action: str | None = None


class CallService(RosbridgeOperation):
    """Call a service.

    Attributes:
        service: Its name.
        args: The fields of the request, by name or in order.
        timeout: Seconds to wait for the response.
    """

    service: Name
    args: Any = None
    timeout: Annotated[float, Field(gt=0, le=300)] = 5.0
    fragment_size: FragmentSize = None


class Advertise(RosbridgeOperation):
    """Tell the type of a topic, before messages are published on it."""

    topic: Name
    type: Name


class Unadvertise(RosbridgeOperation):
    """Publish no more on a topic."""

    topic: Name


class Publish(RosbridgeOperation):
    """Publish a message. Its type has to be advertised if no other node has the topic."""

    topic: Name
    msg: Any = None


class SetLevel(RosbridgeOperation):
    """Choose which status messages are sent."""

    level: Literal["none", "error", "warning", "info"]


# Operations of rosbridge that the gateway does not have, and why.
REFUSED = {
    "advertise_service": "a client cannot offer services through the gateway",
    "unadvertise_service": "a client cannot offer services through the gateway",
    "service_response": "a client cannot offer services through the gateway",
    "advertise_action": "a client cannot offer actions through the gateway",
    "unadvertise_action": "a client cannot offer actions through the gateway",
    "action_feedback": "a client cannot offer actions through the gateway",
    "action_result": "a client cannot offer actions through the gateway",
    "auth": "log in with a token or a ticket when you connect",
}


def read_operation(text: str | bytes) -> tuple[str, Identity, Json]:
    """Return the name, the id and the other fields of an operation.

    Raises:
        MalformedRequest: It is not JSON.
        InvalidField: It is not an operation.
        NotAllowed: It is one that the gateway does not have on purpose.
    """
    try:
        message = decode_json(text, "the message", constants=True)
    except MalformedRequest as error:
        if not says(text, "service", STOP_SERVICE):
            raise
        return "call_service", None, {"service": STOP_SERVICE, "args": error}
    if not isinstance(message, dict):
        raise InvalidField([FieldError("", "an object with op", "got something else")])
    op, identity = message.pop("op", None), message.pop("id", None)
    if not isinstance(op, str):
        raise InvalidField([FieldError("op", "a string", "got none" if op is None else "got something else")])
    if not isinstance(identity, str | int | None) or len(str(identity)) > MAX_ID:
        if is_stop(op, message):  # carried out whatever else it says
            return op, None, message
        raise InvalidField([FieldError("id", f"a text of at most {MAX_ID} characters", "got something else")])
    if op in REFUSED:
        raise NotInstalled(REFUSED[op], code="not_supported")
    return op, identity, message


def is_stop(op: str, fields: Json) -> bool:
    """Return whether an operation calls the service that stops robots."""
    service = fields.get("service") if op == "call_service" else None
    return isinstance(service, str) and is_stop_service(split_name(service, None)[0])


def stop_request(fields: Json) -> object:
    """Return what a call of the service that stops robots says; `args` may have its fields in order."""
    args = fields.get("args")
    if isinstance(args, list):
        fields = dict(zip(("robot", "latch", "by"), args, strict=False))
        in_order = len(args) <= len(fields) and isinstance(fields.get("latch", True), bool)
        return fields if in_order else {"robot": args}
    return args if isinstance(args, dict | GatewayError) else {"robot": args}


def split_name(name: str, identity: Identity) -> tuple[str, Identity]:
    """Return a name without the id that old clients put behind it (`/service#7`), and the id."""
    plain, separator, behind = name.partition("#")
    return plain, behind if separator and identity is None else identity


def stamp(time: datetime) -> Json:
    """Return a time as a message of ROS."""
    return {"sec": int(time.timestamp()), "nanosec": time.microsecond * 1000}


def status(level: Level, text: str, identity: Identity) -> bytes:
    """Return a status message."""
    return _message("status", identity, level=level.name, msg=text)


def service_response(service: str, identity: Identity, values: Any, *, result: bool = True) -> bytes:
    """Return the answer of a service; if it failed, `values` says why."""
    return _message("service_response", identity, service=service, values=values, result=result)


def action_feedback(action: str, identity: Identity, values: Any) -> bytes:
    """Return the feedback of a goal."""
    return _message("action_feedback", identity, action=action, values=values)


# action_msgs/GoalStatus, where a goal has a result: rosbridge calls each of them a success.
_ENDED = {GoalStatus.SUCCEEDED: 4, GoalStatus.CANCELED: 5, GoalStatus.ABORTED: 6}


def action_result(action: str, identity: Identity, status: GoalStatus, values: Any, reason: str = "") -> bytes:
    """Return the end of a goal; without its result (`values` None), the reason."""
    code = _ENDED.get(status, 0)
    values = reason if values is None else values
    return _message("action_result", identity, action=action, values=values, status=code, result=values is not reason)


def published(topic: str, message: Any) -> bytes:
    """Return a message on a topic."""
    return _message("publish", None, topic=topic, msg=message)


def png(image: bytes) -> bytes:
    """Return a message that is an image."""
    return _message("png", None, data=b64encode(image).decode())


def fragment(data: str, number: int, total: int, identity: Identity) -> bytes:
    """Return a piece of a message."""
    return _message("fragment", identity, data=data, num=number, total=total)


def _message(op: str, identity: Identity, **fields: Any) -> bytes:
    return encode({"op": op, **fields} | ({} if identity is None else {"id": identity}))
