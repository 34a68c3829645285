"""The messages of the Foxglove WebSocket protocol: what a client sends, and what it is sent. No ROS, no socket."""

import struct
from collections.abc import Iterable
from enum import IntEnum
from typing import Annotated, Any, NamedTuple

from pydantic import BaseModel, ConfigDict, Field

from dock_gateway.core.errors import FieldError, InvalidField, MalformedRequest, NotInstalled
from dock_gateway.core.goal import encode
from dock_gateway.core.json_text import decode_json

Json = dict[str, Any]

# The names of the protocol, which a client offers when it connects.
SUBPROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")
# How messages are encoded that clients send; the first one is what viewers choose.
ENCODINGS = ("cdr", "json")
# How message types are described.
SCHEMA_ENCODING = "ros2msg"
# Characters of a name, an id or an encoding.
MAX_NAME = 1000
# Limits: parameters of one operation, and parameters that a client subscribes to.
MAX_PARAMETERS = 5000

Id = Annotated[int, Field(ge=0, lt=2**32, strict=True)]
Name = Annotated[str, Field(min_length=1, max_length=MAX_NAME)]


class Level(IntEnum):
    """The levels of status messages."""

    info = 0
    warning = 1
    error = 2


class FoxgloveOperation(BaseModel):
    """An operation. Fields that are not known are ignored: each version of the protocol adds some."""

    model_config = ConfigDict(extra="ignore")


class ChannelSubscription(FoxgloveOperation):
    """A channel, and the client's own id for its messages."""

    id: Id
    channel: Id = Field(alias="channelId")


class Subscribe(FoxgloveOperation):
    """Send the messages of channels."""

    subscriptions: list[ChannelSubscription]


class Unsubscribe(FoxgloveOperation):
    """Send no more messages of channels."""

    subscriptions: list[Id] = Field(alias="subscriptionIds")


class ClientChannel(FoxgloveOperation):
    """A channel on which a client publishes."""

    id: Id
    topic: Name
    encoding: Name
    schema_name: Name = Field(alias="schemaName")


class Advertise(FoxgloveOperation):
    """Prepare for messages on channels of the client."""

    channels: list[ClientChannel]


class Unadvertise(FoxgloveOperation):
    """Forget channels of the client."""

    channels: list[Id] = Field(alias="channelIds")


class GetParameters(FoxgloveOperation):
    """Send the values of parameters; without names, of all."""

    names: Annotated[list[Name], Field(alias="parameterNames", max_length=MAX_PARAMETERS)]
    id: Annotated[str, Field(max_length=MAX_NAME)] | None = None


class ParameterIn(FoxgloveOperation):
    """A parameter to be set."""

    name: Name
    value: Any = None
    type: str | None = None


class SetParameters(FoxgloveOperation):
    """Set parameters."""

    parameters: Annotated[list[ParameterIn], Field(max_length=MAX_PARAMETERS)]
    id: Annotated[str, Field(max_length=MAX_NAME)] | None = None


class ParameterNames(FoxgloveOperation):
    """Parameters that a client subscribes to or unsubscribes from; without names, all."""

    names: Annotated[list[Name], Field(alias="parameterNames", max_length=MAX_PARAMETERS)]


# Operations of the protocol that the gateway does not have, and why.
REFUSED = {
    "fetchAsset": "the gateway hands out no files",
    "playbackControlRequest": "the gateway shows what happens now",
}


class Call(NamedTuple):
    """A call of a service."""

    service: int
    call: int
    encoding: str
    request: bytes


class ClientMessage(NamedTuple):
    """A message on a channel of the client."""

    channel: int
    message: bytes


def read_operation(text: str) -> tuple[str, Json]:
    """Return the name and the other fields of an operation.

    Raises:
        MalformedRequest: It is not JSON.
        InvalidField: It is not an operation.
        NotAllowed: It is one that the gateway does not have on purpose.
    """
    message = decode_json(text, "the message")
    if not isinstance(message, dict):
        raise InvalidField([FieldError("", "an object with op", "got something else")])
    op = message.pop("op", None)
    if not isinstance(op, str):
        raise InvalidField([FieldError("op", "a string", "got none" if op is None else "got something else")])
    if op in REFUSED:
        raise NotInstalled(REFUSED[op], code="not_supported")
    return op, message


def read_binary(data: bytes) -> Call | ClientMessage:
    """Return a binary message.

    Raises:
        MalformedRequest: It is none of the protocol.
    """
    try:
        match data[:1]:
            case b"\x01":
                (channel,) = struct.unpack_from("<I", data, 1)
                return ClientMessage(channel, data[5:])
            case b"\x02" if len(data) >= 5:
                # One that is cut off may be a stop: who carries it out judges its encoding.
                service, call, length = struct.unpack_from("<III", data[:13].ljust(13, b"\0"), 1)
                encoding = data[13 : 13 + length].decode(errors="replace") if length <= MAX_NAME else ""
                return Call(service, call, encoding, data[13 + length :])
    except struct.error:
        pass
    raise MalformedRequest("a binary message is neither a message on a channel nor a call of a service")


def server_info(capabilities: Iterable[str], metadata: dict[str, str], session: str) -> bytes:
    """Return the first message to a client."""
    return encode(
        {
            "op": "serverInfo",
            "name": "dock-gateway",
            "capabilities": list(capabilities),
            "supportedEncodings": ENCODINGS,
            "metadata": metadata,
            "sessionId": session,
        }
    )


def status(level: Level, text: str) -> bytes:
    """Return a message that a viewer shows to its user."""
    return encode({"op": "status", "level": level, "message": text})


def advertise(channels: Iterable[Json]) -> bytes:
    """Return the message that there are channels."""
    return encode({"op": "advertise", "channels": list(channels)})


def unadvertise(channels: Iterable[int]) -> bytes:
    """Return the message that channels are gone."""
    return encode({"op": "unadvertise", "channelIds": list(channels)})


def advertise_services(services: Iterable[Json]) -> bytes:
    """Return the message that there are services."""
    return encode({"op": "advertiseServices", "services": list(services)})


def unadvertise_services(services: Iterable[int]) -> bytes:
    """Return the message that services are gone."""
    return encode({"op": "unadvertiseServices", "serviceIds": list(services)})


def service_call_failure(call: Call, text: str) -> bytes:
    """Return the message that a call has failed."""
    return encode({"op": "serviceCallFailure", "serviceId": call.service, "callId": call.call, "message": text})


def service_call_response(call: Call, response: bytes) -> bytes:
    """Return the response to a call, encoded as its request was."""
    encoding = call.encoding.encode()
    return struct.pack("<BIII", 3, call.service, call.call, len(encoding)) + encoding + response


def parameter_values(parameters: list[Json], identity: str | None = None) -> bytes:
    """Return the values of parameters."""
    message = {"op": "parameterValues", "parameters": parameters}
    return encode(message if identity is None else {**message, "id": identity})


def message_data(subscription: int, received_ns: int, message: bytes) -> bytes:
    """Return a message on a channel."""
    return struct.pack("<BIQ", 1, subscription, received_ns) + message
