"""Reads a localization: when it was heard last, and how well it knows the robot's pose."""

import math

from geometry_msgs.msg import PoseWithCovarianceStamped

TOPIC = "amcl_pose"
"""Where AMCL publishes its covariance; remap it to that of another localization."""


class LocalizationState:
    """Keeps the state of the localization that relates the dock's frame to odometry's.

    Attributes:
        heard_at: When a transform of it came that was not there before; by the observations' clock.
        error: Its standard deviation along the longest axis, in m; NaN where it does not say.
    """

    def __init__(self) -> None:
        """Start without a localization."""
        self.heard_at, self.error = -math.inf, math.nan
        self._stamp = math.nan

    def take(self, message: PoseWithCovarianceStamped, _received: float) -> None:
        """Note the covariance; one of zeros says nothing.

        Raises:
            ValueError: It is not a number; the caller adds the subject to the message.
        """
        covariance = message.pose.covariance
        xx, xy, yy = covariance[0], covariance[1], covariance[7]
        variance = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)
        if not math.isfinite(variance):
            raise ValueError("has a covariance that is not a number")
        self.error = math.sqrt(variance) if variance > 0.0 else math.nan

    def note(self, stamp: float | None, now: float) -> None:
        """Note how new the transforms are.

        Args:
            stamp: Of the last one, by the publisher's clock; None where they never change.
            now: The moment.
        """
        if stamp is None or stamp != self._stamp:
            self.heard_at, self._stamp = now, math.nan if stamp is None else stamp
