"""What a subscription holds of what users share."""

from contextlib import ExitStack
from unittest.mock import AsyncMock

import pytest

from dock_gateway.core.errors import NotFound
from dock_gateway.core.grant import Role
from dock_gateway.core.request import slot
from dock_gateway.core.work import Work
from dock_gateway.extensions.rosbridge.protocol import Subscribe
from dock_gateway.extensions.rosbridge.subscriptions import RosbridgeSubscriptions
from dock_gateway.graph.relays import Relays
from dock_gateway.http.parts import Parts
from dock_gateway.http.quotas import Quotas, limits
from dock_gateway.settings import Settings
from tests.support.permits import acting, user

VIEWER = user("viewer", Role.VIEWER)


async def test_a_subscription_that_fails_keeps_no_place() -> None:
    """Such as one of a type that is not installed, again and again."""
    relays = AsyncMock(Relays)
    relays.join.side_effect = NotFound("its package is not installed", code="interface_not_found")
    subscriptions = RosbridgeSubscriptions(Parts({Relays: relays, Work: AsyncMock(Work)}), VIEWER, None)
    with acting(Quotas(Settings()), VIEWER):
        for number in range(100):
            topic = f"/topic{number}"
            with pytest.raises(NotFound):
                await subscriptions.subscribe(topic, "bad_package/msg/Bad", number, Subscribe(topic=topic))
        with ExitStack() as stack:
            for _ in range(int(limits(Settings())["topics"].share)):  # all of them are free
                stack.enter_context(slot("topics"))
