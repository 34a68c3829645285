"""Messages of subscriptions, taken without rclpy's executor.

The executor looks at every entity of the node again for each message, in Python: 0.2 ms with one action, 5 ms with a
hundred. Here a thread waits for subscriptions alone, looks at them again only when there are others, and takes all
that has come before it waits again.
"""

import threading
from collections.abc import Iterable
from contextlib import ExitStack
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.context import Context
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.guard_condition import GuardCondition
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.subscription import Subscription

from dock_gateway.ros.threads import RosThread

# So many messages of one subscription in a row, then it is the turn of the others.
BURST = 100


class NotForExecutors(CallbackGroup):  # type: ignore[misc]
    """Keeps subscriptions away from the executor."""

    def can_execute(self, _: object) -> bool:
        """Whether an executor may run something of this group."""
        return False

    def beginning_execution(self, _: object) -> bool:
        """Whether an executor may begin to."""
        return False

    def ending_execution(self, _: object) -> None:
        """Nothing to do."""


class Listener:
    """Calls the callbacks of subscriptions, `(message, info)`, on a thread of its own. They must not raise."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._wake = GuardCondition(None, None, context=context)
        self._lock = threading.Lock()
        self._subscriptions: list[Subscription] = []
        self._changed = True
        self._thread = RosThread("ros-listener", self._listen)

    @property
    def alive(self) -> bool:
        """Whether the thread runs."""
        return self._thread.alive

    def start(self) -> None:
        """Listen from now on."""
        self._thread.start()

    def close(self) -> bool:
        """Stop listening; False where the thread does not end."""
        self._thread.stopping = True
        self._wake.trigger()
        return self._thread.end()

    def add(self, subscription: Subscription) -> None:
        """Hear a subscription, too."""
        with self._lock:
            self._subscriptions.append(subscription)
            self._changed = True
        self._wake.trigger()

    def remove(self, subscription: Subscription) -> bool:
        """No longer hear a subscription; False where it was not heard. It may be destroyed at once."""
        with self._lock:
            if subscription not in self._subscriptions:
                return False
            self._subscriptions.remove(subscription)
            self._changed = True
        self._wake.trigger()
        return True

    def _listen(self) -> None:
        while not self._thread.stopping:
            with self._lock:
                wanted, self._changed = list(self._subscriptions), False
            # What is held open is not destroyed while it is waited for.
            with ExitStack() as held:
                held.enter_context(self._context.handle)
                held.enter_context(self._wake.handle)
                self._listen_to(dict(_hold(held, wanted)))

    def _listen_to(self, subscriptions: dict[int, Subscription]) -> None:
        wait_set = _rclpy.WaitSet(len(subscriptions), 1, 0, 0, 0, 0, self._context.handle)
        while not (self._changed or self._thread.stopping):
            wait_set.clear_entities()
            for subscription in subscriptions.values():
                wait_set.add_subscription(subscription.handle)
            wait_set.add_guard_condition(self._wake.handle)
            wait_set.wait(-1)
            for pointer in wait_set.get_ready_entities("subscription"):
                _take_all(subscriptions[pointer])


def _hold(held: ExitStack, wanted: Iterable[Subscription]) -> Iterable[tuple[int, Subscription]]:
    for subscription in wanted:
        try:
            held.enter_context(subscription.handle)
        except _rclpy.InvalidHandle:  # destroyed meanwhile
            continue
        yield subscription.handle.pointer, subscription


def _take_all(subscription: Subscription) -> None:
    for _ in range(BURST):
        taken = subscription.handle.take_message(subscription.msg_type, subscription.raw)
        if taken is None:
            return
        subscription.callback(*taken)


class ListeningNode(Node):  # type: ignore[misc]
    """A node whose guarded subscriptions are heard by a listener; the others, of rclpy's own, by the executor."""

    def __init__(self, name: str, namespace: str | None, context: Context, listener: Listener) -> None:
        self._listener = listener
        super().__init__(name, namespace=namespace, context=context)

    def create_subscription(self, msg_type: Any, topic: str, callback: Any, *args: Any, **options: Any) -> Subscription:
        """As rclpy has it."""
        if not getattr(callback, "guarded", False):
            return super().create_subscription(msg_type, topic, callback, *args, **options)
        # An executor that waits for a subscription's events is woken by each of its messages, too.
        options["event_callbacks"] = SubscriptionEventCallbacks(use_default_callbacks=False)
        options["callback_group"] = NotForExecutors()
        subscription = super().create_subscription(msg_type, topic, callback, *args, **options)
        self._listener.add(subscription)
        return subscription

    def destroy_subscription(self, subscription: Subscription) -> bool:
        """As rclpy has it."""
        self._listener.remove(subscription)
        return bool(super().destroy_subscription(subscription))
