"""Decides how long zero velocity is repeated to stop a robot. Pure.

One message may be lost, and a base without a command timeout goes on with its last command. DDS may also find the base
only after the last repetition: a publisher does not reach a subscriber that it has not been matched with yet. But the
wheels belong to the next who drives, and two that command in turn make a robot jerk.
"""

PERIOD = 0.05
"""Seconds between two zeros."""
REPEATS = 10
"""How often zero velocity is repeated at least: of 11 messages, all are lost once in 500,000 times if 30 % are."""
LONGEST = 5.0
"""Seconds after which it is repeated no longer, even if odometry says that the robot moves."""
DISCOVERY = 10.0
"""Seconds after a stop in which a new subscriber gets zero velocity, too. DDS announces a participant every 3 s."""


class Halt:
    """Stops a robot once: zero velocity at once, and again until it stands.

    Attributes:
        began: When it began, in seconds of the monotonic clock.
        over: Whether zero velocity will not be repeated any more.
    """

    def __init__(self, began: float, subscribers: int | None = None) -> None:
        """Begin.

        Args:
            began: When zero velocity was published first.
            subscribers: How many subscriptions the publisher was matched with then; None: new ones are not waited for.
        """
        self.began = began
        self.over = False
        self._subscribers = subscribers
        self._left = REPEATS

    def repeat(self, now: float, *, moves: bool, commanded_at: float, subscribers: int = 0) -> bool:
        """Whether zero velocity has to be published again now.

        Args:
            now: The current time.
            moves: Whether odometry says that the robot moves; not where there is none.
            commanded_at: When another node last commanded a motion.
            subscribers: How many subscriptions the publisher is matched with; read before zero velocity is published.
        """
        if self._subscribers is not None:
            if subscribers > self._subscribers:
                self._left = REPEATS + 1
            self._subscribers = subscribers
        self._left -= 1
        due = self._left >= 0 or (moves and now - self.began < LONGEST)
        waits = self._subscribers is not None and now - self.began < DISCOVERY
        self.over = self.over or commanded_at > self.began or not (due or waits)
        return due and not self.over
