"""The active alerts, wherever they come from."""

from typing import Any, Protocol

from dock_gateway.core.grant import UNLIMITED, Grant
from dock_gateway.core.listeners import Listeners

# Seconds after the start after which what was known of an alert that has not recurred is forgotten: it has ended.
SETTLED_AFTER = 60.0


class Alerts(Protocol):
    """The active alerts.

    Attributes:
        on_change: Called when an alert begins or ends.
    """

    on_change: Listeners[[]]

    def documents(self, grant: Grant = UNLIMITED) -> list[dict[str, Any]]:
        """Return the alerts of a grant as `GET /alerts` shows them: critical ones first, then oldest first."""

    def get(self, alert_id: str, grant: Grant = UNLIMITED) -> object:
        """Return an alert.

        Raises:
            NotFound: There is none, or the grant does not cover it (`alert_not_found`).
        """
