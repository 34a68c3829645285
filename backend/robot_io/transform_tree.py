"""The tree of the robot's frames, as /tf and /tf_static tell it: how one frame lies in another at a moment."""

from bisect import bisect_right
from collections import deque
from dataclasses import dataclass, field
from itertools import pairwise

from robot_io.transform import Transform

KEPT = 3.0
"""Seconds of transforms to look back into."""
SLACK = 0.25
"""Up to this many seconds before the oldest transform, or after the newest, that transform is used."""
MOST = 1000
"""Frames that are kept, and transforms of each: more means that a publisher invents names, or moments."""


class TransformError(Exception):
    """A frame cannot be related to another one; the text says why."""


@dataclass(slots=True)
class _Link:
    """A frame in its parent frame.

    Attributes:
        parent: The name of the parent frame.
        fixed: Whether it never moves.
        samples: By the moments they were measured at; only the last one where it never moves.
    """

    parent: str
    fixed: bool
    samples: deque[tuple[float, Transform]] = field(default_factory=lambda: deque(maxlen=MOST))

    def add(self, measured_at: float, transform: Transform) -> None:
        """Take in a transform. One that is older than the last means that the clock was set back: forget the others."""
        samples = self.samples
        if self.fixed or (samples and measured_at < samples[-1][0]):
            samples.clear()
        elif samples and measured_at == samples[-1][0]:
            samples.pop()
        samples.append((measured_at, transform))
        while measured_at - samples[0][0] > KEPT:
            samples.popleft()

    def at(self, measured_at: float) -> Transform:
        """The transform at a moment; 0 is now.

        Raises:
            TransformError: There is none for that moment.
        """
        samples = self.samples
        (first, oldest), (last, newest) = samples[0], samples[-1]
        if self.fixed or measured_at == 0.0:
            return newest
        if measured_at > last + SLACK:
            raise TransformError(f"is {measured_at - last:.1f} s older than the measurement")
        if measured_at < first - SLACK:
            raise TransformError(f"is known only from {first - measured_at:.1f} s after the measurement on")
        index = bisect_right(samples, measured_at, key=lambda sample: sample[0])
        if index == 0:
            return oldest
        if index == len(samples):
            return newest
        (before_at, before), (after_at, after) = samples[index - 1], samples[index]
        return before.interpolate(after, (measured_at - before_at) / (after_at - before_at))


class TransformTree:
    """Frames by their names, each with its parent. Moments are seconds of the clock that the messages carry."""

    def __init__(self) -> None:
        self._links: dict[str, _Link] = {}

    def add(self, parent: str, child: str, measured_at: float, transform: Transform, *, fixed: bool = False) -> None:
        """Add a transform. A frame has one parent, the last one that was published.

        Args:
            parent: The parent frame.
            child: The frame.
            measured_at: When it was measured; of no interest where it is fixed.
            transform: The child in its parent.
            fixed: Whether it never moves, as those of /tf_static.

        Raises:
            ValueError: It cannot be used; the caller adds the subject to the message.
        """
        if not parent or not child:
            raise ValueError("has a transform without the names of its frames")
        if parent == child:
            raise ValueError(f"has a transform from '{child}' to itself")
        link = self._links.get(child)
        if link is None and len(self._links) >= MOST:
            raise ValueError(f"has more than {MOST} frames: '{child}' is left out")
        if link is None or link.parent != parent or link.fixed != fixed:
            link = self._links[child] = _Link(parent, fixed)
        link.add(measured_at, transform)

    def forget_moving(self) -> None:
        """Forget all transforms except fixed ones."""
        self._links = {child: link for child, link in self._links.items() if link.fixed}

    def path(self, frame: str, target: str) -> list[str]:
        """The frames from one to another, both included, by way of the frame that they have in common.

        Raises:
            TransformError: There is no way.
        """
        up, down = self._chain(frame), self._chain(target)
        common = next((name for name in up if name in down), None)
        if common is None:
            raise TransformError(self._explain(frame, target, up[-1], down[-1]))
        return [*up[: up.index(common) + 1], *reversed(down[: down.index(common)])]

    def lookup(self, target: str, frame: str, measured_at: float) -> Transform:
        """Return where a frame lies in another one.

        Args:
            target: The frame that the transform is given in.
            frame: The frame that is looked for.
            measured_at: The moment; 0, a stamp that was not set, is now.

        Raises:
            TransformError: There is no way from one to the other, or not for that moment.
        """
        path = self.path(frame, target)
        transform = Transform()
        for child, parent in pairwise(path):
            link = self._links.get(child)
            if link is not None and link.parent == parent:
                transform = self._at(child, measured_at).compose(transform)
            else:
                transform = self._at(parent, measured_at).inverse().compose(transform)
        return transform

    def newest(self, target: str, frame: str) -> float | None:
        """Return when the oldest of the last transforms between two frames was measured; None where all are fixed.

        Args:
            target: One of the frames.
            frame: The other one.

        Raises:
            TransformError: There is no way from one to the other.
        """
        path = self.path(frame, target)
        links = [
            self._links[child]
            for one, other in pairwise(path)
            for child, parent in ((one, other), (other, one))
            if child in self._links and self._links[child].parent == parent
        ]
        return min((link.samples[-1][0] for link in links if not link.fixed), default=None)

    def _at(self, child: str, measured_at: float) -> Transform:
        link = self._links[child]
        try:
            return link.at(measured_at)
        except TransformError as error:
            raise TransformError(f"the transform from '{child}' to '{link.parent}' {error}") from None

    def _chain(self, frame: str) -> list[str]:
        """A frame, its parent, the parent of that, up to the root."""
        chain = [frame]
        while (link := self._links.get(chain[-1])) is not None:
            if link.parent in chain:
                loop = [*chain[chain.index(link.parent) :], link.parent]
                raise TransformError(f"the frames are a loop: {' in '.join(map(repr, loop))}")
            chain.append(link.parent)
        return chain

    def _explain(self, frame: str, target: str, root: str, other_root: str) -> str:
        known = {*self._links, *(link.parent for link in self._links.values())}
        if missing := [f"'{name}'" for name in (frame, target) if name not in known]:
            return f"no transform has {' or '.join(missing)}"
        return f"no transform relates '{root}' to '{other_root}'"


def nearer_frame(tree: TransformTree, frame: str, odometry: str, base: str) -> str:
    """Return which of odometry's two frames a frame is to be related to.

    It is `odometry` if the way from the frame to the robot leads through it, as from a map, else `base`: between these
    two, odometry itself is believed and not `tf`.

    Args:
        tree: The frames.
        frame: The frame.
        odometry: The frame that odometry is given in.
        base: The frame of the robot.

    Raises:
        TransformError: The frame is related to neither.
    """
    try:
        path = tree.path(frame, base)
    except TransformError as error:
        try:
            tree.path(frame, odometry)
        except TransformError:
            raise error from None
        return odometry
    return odometry if odometry in path else base
