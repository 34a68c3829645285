"""How long zero velocity is repeated to stop a robot. Pure.

One message may be lost, and a base without a command timeout goes on with its last command. But the wheels
belong to the next who drives, and two that command in turn make a robot jerk.
"""

PERIOD = 0.05
"""Seconds between two zeros."""
REPEATS = 10
"""How often zero velocity is repeated at least: of 11 messages, all are lost once in 500,000 times if 30 % are."""
LONGEST = 5.0
"""Seconds after which it is repeated no longer, even if odometry says that the robot moves."""


class Halt:
    """Stops a robot once: zero velocity at once, and again until it stands.

    Attributes:
        began: When it began, in seconds of the monotonic clock.
    """

    def __init__(self, began: float) -> None:
        """Begin.

        Args:
            began: When zero velocity was published first.
        """
        self.began = began
        self._left = REPEATS
        self._over = False

    def repeat(self, now: float, *, moves: bool, commanded_at: float) -> bool:
        """Whether zero velocity has to be published again. Once it need not be, this halt is over.

        Args:
            now: The current time.
            moves: Whether odometry says that the robot moves; not where there is none.
            commanded_at: When another node last commanded a motion.
        """
        self._left -= 1
        due = self._left >= 0 or (moves and now - self.began < LONGEST)
        self._over = self._over or not due or commanded_at > self.began
        return not self._over
