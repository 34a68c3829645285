"""What the tests of webhooks share."""

from collections.abc import Iterator

import pytest

from tests.support.webhooks import Receiver, running_receiver


@pytest.fixture
def receiver() -> Iterator[Receiver]:
    """A server that webhooks are sent to."""
    with running_receiver() as receiver:
        yield receiver
