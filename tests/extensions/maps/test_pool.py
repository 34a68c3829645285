"""What several robots share."""

from dock_gateway.extensions.maps.pool import Pool


async def test_what_is_shared_is_closed_by_the_last() -> None:
    closed: list[str] = []

    class Part:
        def __init__(self, topic: str) -> None:
            self.topic = topic

        async def close(self) -> None:
            closed.append(self.topic)

    pool = Pool(Part)
    assert pool.take("/map") is pool.take("/map")
    await pool.give("/map")
    assert not closed
    await pool.give("/map")
    assert closed == ["/map"]
