"""Of the forms of a camera, the best one that has pictures is read, and it alone."""

import asyncio
from types import SimpleNamespace
from typing import Any, cast

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dock_gateway.extensions.cameras import forms as module
from dock_gateway.extensions.cameras.forms import Forms
from tests.support.waiting import PATIENCE, until

TOPICS = ("/front/compressed", "/front", "/front/compressedDepth")
TICK, SILENT = 0.01, 0.08


class Camera:
    """A camera whose forms speak or not; notes what is read, and what comes of it."""

    def __init__(self) -> None:
        self.joined: set[str] = set()
        self.taken: list[str] = []
        self.broken: set[str] = set()
        self.speaking: set[str] = set()
        self.forms = Forms(cast("Any", self), TOPICS, self, tick=TICK)

    async def join(self, topic: str, _: None, __: object) -> None:
        self.joined.add(topic)

    async def leave(self, topic: str, _: object) -> None:
        self.joined.remove(topic)

    async def offer(self, message: Any) -> None:
        self.taken.append(message.topic)
        self.forms.judge(message.topic, readable=message.topic not in self.broken)

    async def publish(self) -> None:
        """One picture of each form that speaks and is read."""
        for topic in TOPICS:
            if topic in self.speaking & self.joined:
                await self.forms.offer(cast("Any", SimpleNamespace(topic=topic)))

    async def run(self, wanted: set[str]) -> None:
        """Publish until these forms are read, and no others."""

        async def once() -> None:
            while self.joined != wanted:
                await self.publish()
                await asyncio.sleep(TICK / 2)

        await asyncio.wait_for(once(), PATIENCE)


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SILENT", SILENT)
    monkeypatch.setattr(module, "MAX_SILENT", SILENT)


steps = st.lists(
    st.tuples(st.sets(st.sampled_from(TOPICS)), st.sets(st.sampled_from(TOPICS), max_size=1)), min_size=1, max_size=4
)


@given(steps)
@settings(max_examples=25, deadline=None)
async def test_the_best_form_that_speaks_is_read_alone_and_all_while_none_does(
    steps: list[tuple[set[str], set[str]]],
) -> None:
    """Whatever begins, falls silent or becomes unreadable in the meantime."""
    module.SILENT = module.MAX_SILENT = SILENT  # type: ignore[misc]
    camera = Camera()
    await camera.forms.open()
    try:
        for speaking, broken in steps:
            camera.speaking, camera.broken = speaking, broken
            current = next((topic for topic in TOPICS if {topic} == camera.joined), None)
            good = [topic for topic in TOPICS if topic in speaking - broken]
            if current in good:  # a form that has pictures is kept
                good = [cast("str", current)]
            if not good:
                await camera.run(set(TOPICS))
                continue
            camera.taken.clear()

            def is_read(good: list[str] = good) -> bool:
                return any(topic in good for topic in camera.taken) and len(camera.joined) == 1

            async def once(is_read: Any = is_read) -> None:
                while not is_read():
                    await camera.publish()
                    await asyncio.sleep(TICK / 2)

            await asyncio.wait_for(once(), PATIENCE)
            assert camera.joined <= set(good)
    finally:
        await camera.forms.close()
    assert not camera.joined


async def test_one_form_is_read_alone_even_if_it_is_silent() -> None:
    camera = Camera()
    camera.forms = Forms(cast("Any", camera), TOPICS[1:2], camera, tick=TICK)
    await camera.forms.open()
    await asyncio.sleep(5 * TICK)
    assert camera.joined == {TOPICS[1]}
    await camera.forms.close()


async def test_the_best_form_is_tried_first_and_alone() -> None:
    camera = Camera()
    camera.speaking = set(TOPICS)
    await camera.forms.open()
    assert camera.joined == {TOPICS[0]}
    await camera.publish()
    assert camera.taken == [TOPICS[0]]
    await camera.forms.close()


async def test_what_cannot_be_shown_lets_another_form_be_tried_at_once() -> None:
    camera = Camera()
    camera.forms = Forms(cast("Any", camera), TOPICS, camera, tick=3600.0)
    camera.speaking, camera.broken = set(TOPICS), {TOPICS[0]}
    await camera.forms.open()
    await camera.publish()
    await until(lambda: len(camera.joined) > 1)
    await camera.forms.close()
