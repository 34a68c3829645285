"""All that we use of rclpy's private parts and of the C library below it; nothing else does.

`create_context` calls `require_supported`, so a process says at its start that its rclpy lacks one of them. The layouts
of C structures are those of ROS 2 Iron and later, on every processor: ctypes aligns them as the compiler does.
"""

import ctypes
import importlib.metadata
import uuid
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from types import SimpleNamespace, TracebackType
from typing import Any, Generic, NamedTuple, Self, TypeVar

from rclpy.action import ActionServer
from rclpy.callback_groups import CallbackGroup, ReentrantCallbackGroup
from rclpy.client import Client
from rclpy.context import Context
from rclpy.guard_condition import GuardCondition
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.subscription import Subscription
from rclpy.waitable import NumberOfEntities, Waitable

EntityT = TypeVar("EntityT", Subscription, Client)

RESULT_TIMEOUT = 10
"""How long the result of a goal that has ended can be fetched, in whole seconds."""

# ---------------------------------------------------------------------- what must be there


class UnsupportedRclpyError(RuntimeError):
    """This rclpy lacks what we need; the message is a sentence that names it."""


def _error(name: str) -> type[Exception]:
    """Return an exception of rclpy's inside; one that is missing is reported by `require_supported`."""
    return getattr(_rclpy, name, RuntimeError)


RCLError = _error("RCLError")
InvalidHandle = _error("InvalidHandle")
UnknownROSArgsError = _error("UnknownROSArgsError")
RCLInvalidROSArgsError = _error("RCLInvalidROSArgsError")


def reason(error: Exception) -> str:
    """Return why ROS does not start, from its RCLError, without the places in its sources."""
    return str(error).partition("\n")[0].partition(", at ")[0]


def exists(subscription: Subscription) -> bool:
    """Return whether DDS has a subscription: also one that is destroyed as soon as no thread uses it."""
    return bool(subscription.handle.pointer)


def _library(name: str) -> ctypes.CDLL | None:
    try:
        return ctypes.CDLL(name)
    except OSError:
        return None


_rcl, _rcutils = _library("librcl.so"), _library("librcutils.so")

# The attributes that are looked up in an object, by the name that an error shows for it.
_NEEDED: tuple[tuple[str, Callable[[], object], tuple[str, ...]], ...] = (
    ("rclpy", lambda: _rclpy, ("RCLError", "InvalidHandle", "UnknownROSArgsError", "RCLInvalidROSArgsError")),
    ("rclpy's Context", lambda: getattr(_rclpy, "Context", None), ("__enter__", "pointer")),
    ("rclpy's GuardCondition", lambda: getattr(_rclpy, "GuardCondition", None), ("__enter__", "pointer")),
    ("rclpy's Subscription", lambda: getattr(_rclpy, "Subscription", None), ("__enter__", "pointer")),
    ("rclpy's Client", lambda: getattr(_rclpy, "Client", None), ("__enter__", "pointer", "take_response")),
    (
        "rclpy's WaitSet",
        lambda: getattr(_rclpy, "WaitSet", None),
        (
            "add_client", "add_guard_condition", "add_subscription", "clear_entities", "get_ready_entities", "is_ready",
            "wait",
        ),
    ),
    # Its own, not that of Waitable.
    ("rclpy.action.ActionServer", lambda: SimpleNamespace(**vars(ActionServer)), ("execute",)),
    ("rclpy.client.Client", lambda: Client, ("get_pending_request", "handle", "remove_pending_request")),
    ("rclpy.subscription.Subscription", lambda: Subscription, ("handle",)),
    ("rclpy.waitable.Waitable", lambda: Waitable, ("add_to_wait_set", "execute", "is_ready", "take_data")),
    ("librcl.so", lambda: _rcl, ("rcl_take", "rcl_take_serialized_message")),
    ("librcutils.so", lambda: _rcutils, ("rcutils_get_default_allocator", "rcutils_reset_error")),
)  # fmt: skip


def require_supported() -> None:
    """Check that all private parts that we use are there.

    Raises:
        UnsupportedRclpyError: The message names the version of rclpy and the missing part.
    """
    missing = [
        f"{name} of {owner}" for owner, look_up, names in _NEEDED for name in names if not hasattr(look_up(), name)
    ]
    if not missing:
        return
    try:
        version = importlib.metadata.version("rclpy")
    except importlib.metadata.PackageNotFoundError:
        version = "of an unknown version"
    raise UnsupportedRclpyError(
        f"rclpy {version} is not supported, because it lacks {', '.join(missing)}: use that of ROS 2 Jazzy (7.1) or "
        "Kilted (9.1)"
    )


# ---------------------------------------------------------------------- messages with their publisher


class _MessageInfo(ctypes.Structure):
    """rmw_message_info_t of ROS 2 Iron and later, with room for what a later one may add."""

    _fields_ = (
        ("source_timestamp", ctypes.c_int64),
        ("received_timestamp", ctypes.c_int64),
        ("publication_sequence_number", ctypes.c_uint64),
        ("reception_sequence_number", ctypes.c_uint64),
        ("implementation_identifier", ctypes.c_char_p),
        ("gid", ctypes.c_uint8 * 16),
        ("from_intra_process", ctypes.c_bool),
        ("room", ctypes.c_uint8 * 64),
    )


class _Allocator(ctypes.Structure):
    """rcutils_allocator_t: four functions and their state."""

    _fields_ = tuple((name, ctypes.c_void_p) for name in ("allocate", "free", "grow", "zero", "state"))


class _Bytes(ctypes.Structure):
    """rcutils_uint8_array_t."""

    _fields_ = (
        ("buffer", ctypes.c_void_p),
        ("length", ctypes.c_size_t),
        ("capacity", ctypes.c_size_t),
        ("allocator", _Allocator),
    )


def _function(library: ctypes.CDLL | None, name: str, result: Any, arguments: int) -> Any:
    """Return a C function that takes pointers; None if it is missing, which `require_supported` reports."""
    function = getattr(library, name, None)
    if function is not None:
        function.restype, function.argtypes = result, [ctypes.c_void_p] * arguments
    return function


_rcl_take = _function(_rcl, "rcl_take", ctypes.c_int, 4)
_rcl_take_bytes = _function(_rcl, "rcl_take_serialized_message", ctypes.c_int, 4)
_default_allocator = _function(_rcutils, "rcutils_get_default_allocator", _Allocator, 0)
_reset_error = _function(_rcutils, "rcutils_reset_error", None, 0)
_RCL_RET_OK, _RCL_RET_SUBSCRIPTION_TAKE_FAILED = 0, 401


class Taken(NamedTuple):
    """A message: what it says, its number, its source timestamp in ns, and its publisher's `endpoint_gid`."""

    data: bool
    number: int
    stamp_ns: int
    publisher: bytes


def take_bool(subscription: Subscription) -> Taken | None:
    """Take the next message of a subscription to std_msgs/Bool; None if there is none.

    Raises:
        InvalidHandle: The subscription was destroyed.
    """
    data, info = ctypes.c_bool(), _MessageInfo()
    with subscription.handle:
        failed = _rcl_take(subscription.handle.pointer, ctypes.byref(data), ctypes.byref(info), None)
    if failed:
        return None
    return Taken(data.value, info.publication_sequence_number, info.source_timestamp, bytes(info.gid))


class Buffer:
    """Takes encoded messages, one at a time, and copies only the bytes that are asked for. For one thread.

    Attributes:
        info: About the message: its `source_timestamp` and `received_timestamp` in ns, see `arrived_at`, and its
            `publisher`, an `endpoint_gid`.
    """

    def __init__(self) -> None:
        self.info: dict[str, Any] = {}
        self._info = _MessageInfo()
        self._bytes = _Bytes(allocator=_default_allocator())
        self._addresses = ctypes.addressof(self._bytes), ctypes.addressof(self._info)

    @property
    def size(self) -> int:
        """Size of the message in bytes."""
        return int(self._bytes.length)

    def take(self, subscription: Subscription) -> bool:
        """Take the next message of a subscription, whose handle the caller holds; return False if there is none.

        Raises:
            RuntimeError: ROS fails.
        """
        code = _rcl_take_bytes(subscription.handle.pointer, *self._addresses, None)
        if code == _RCL_RET_SUBSCRIPTION_TAKE_FAILED:
            return False
        if code != _RCL_RET_OK:
            _reset_error()
            raise RuntimeError(f"a message on {subscription.topic_name} could not be taken: rcl returned {code}")
        self.info = {
            "source_timestamp": self._info.source_timestamp,
            "received_timestamp": self._info.received_timestamp,
            "publisher": bytes(self._info.gid),
        }
        return True

    def read(self, limit: int | None = None) -> bytes:
        """Return the message, or its first bytes."""
        size = self.size if limit is None else min(limit, self.size)
        return ctypes.string_at(self._bytes.buffer, size)


def take_response(client: Client) -> tuple[int, Any] | None:
    """Take the next response of a client, whose handle the caller holds: the number of its request, and the response.

    Returns:
        None if there is none.
    """
    header, response = client.handle.take_response(client.srv_type.Response)
    return None if header is None else (header.request_id.sequence_number, response)


# ---------------------------------------------------------------------- waiting


class NotForExecutors(CallbackGroup):  # type: ignore[misc] # rclpy has no types
    """Hides entities from the executor."""

    def can_execute(self, _: object) -> bool:
        """Return False: an executor must not run anything in this group."""
        return False

    def beginning_execution(self, _: object) -> bool:
        """Return False: an executor must not start anything in this group."""
        return False

    def ending_execution(self, _: object) -> None:
        """Do nothing."""


class Waiter(Generic[EntityT]):
    """Waits for messages of subscriptions, or for responses of clients, without rclpy's executor.

    Their handles are held, so that they are not destroyed meanwhile; an entity that was destroyed before is left out.
    """

    def __init__(self, context: Context, wake: GuardCondition, entities: Iterable[EntityT]) -> None:
        """Take what to wait for.

        Args:
            context: The context of the entities.
            wake: Ends a wait when it is triggered.
            entities: The subscriptions, or the clients.
        """
        self._context = context
        self._wake = wake
        self._wanted = entities
        self._held = ExitStack()

    def __enter__(self) -> Self:
        self._held.enter_context(self._context.handle)
        self._held.enter_context(self._wake.handle)
        self._entities: dict[int, EntityT] = {}
        for entity in self._wanted:
            try:
                self._held.enter_context(entity.handle)
            except InvalidHandle:  # destroyed meanwhile
                continue
            self._entities[entity.handle.pointer] = entity
        subscriptions = [entity for entity in self._entities.values() if isinstance(entity, Subscription)]
        clients = [entity for entity in self._entities.values() if isinstance(entity, Client)]
        self._subscriptions = [subscription.handle for subscription in subscriptions]
        self._clients = [client.handle for client in clients]
        self._wait_set = _rclpy.WaitSet(len(subscriptions), 1, 0, len(clients), 0, 0, self._context.handle)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._held.close()

    def wait(self) -> list[EntityT]:
        """Wait until there is something to take, or until `wake` is triggered; return what may have something."""
        wait_set = self._wait_set
        wait_set.clear_entities()
        for subscription in self._subscriptions:
            wait_set.add_subscription(subscription)
        for client in self._clients:
            wait_set.add_client(client)
        wait_set.add_guard_condition(self._wake.handle)
        wait_set.wait(-1)
        kinds = (("subscription", self._subscriptions), ("client", self._clients))
        ready = [pointer for kind, handles in kinds if handles for pointer in wait_set.get_ready_entities(kind)]
        return [self._entities[pointer] for pointer in ready]


class SubscriptionWaitable(Waitable):  # type: ignore[misc] # rclpy has no types
    """Lets the executor wait for a subscription that is `NotForExecutors`, and leaves taking its messages to others."""

    def __init__(self, subscription: Subscription, take: Callable[[], None]) -> None:
        """Take a subscription.

        Args:
            subscription: The subscription to wait for.
            take: Called in the executor's thread when there are messages; takes them all.
        """
        super().__init__(ReentrantCallbackGroup())
        self.subscription = subscription
        self._take = take
        self._index = -1

    def __enter__(self) -> None:
        self.subscription.handle.__enter__()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.subscription.handle.__exit__(kind, error, trace)

    def get_num_entities(self) -> NumberOfEntities:
        """Return how many entities it adds to a wait set."""
        return NumberOfEntities(1)

    def add_to_wait_set(self, wait_set: Any) -> None:
        """Add the subscription to a wait set."""
        self._index = wait_set.add_subscription(self.subscription.handle)

    def is_ready(self, wait_set: Any) -> bool:
        """Return whether there are messages, after a wait."""
        return bool(wait_set.is_ready("subscription", self._index))

    def take_data(self) -> None:
        """Take the messages."""
        self._take()

    async def execute(self, taken_data: None) -> None:
        """All is done."""


# ---------------------------------------------------------------------- action servers


class IdentifyingActionServer(ActionServer):  # type: ignore[misc] # rclpy has no types
    """An rclpy ActionServer whose goal callback can ask for the id of the goal it decides on.

    rclpy hands the goal callback the goal's fields and no id, so that a rejection could not be attributed. Of all
    ways around that, `execute` of the Waitable interface is the one least bound to rclpy's inside: it is given the
    whole request, and calls the goal callback before anything else can run.

    Attributes:
        deciding_on: Inside the goal callback: the id of the goal.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        self.deciding_on = ""
        super().__init__(*args, result_timeout=RESULT_TIMEOUT, **kwargs)

    async def execute(self, taken_data: dict[str, Any]) -> None:
        """Note the goal id of a request, then go on as always."""
        if "goal" in taken_data:
            _header, request = taken_data["goal"]
            self.deciding_on = goal_id_text(request.goal_id)
        await super().execute(taken_data)


def goal_id_text(message: Any) -> str:
    """A unique_identifier_msgs/UUID as the canonical text that `ros2 action send_goal` prints."""
    return str(uuid.UUID(bytes=bytes(message.uuid)))
