"""The state of the connection to the hub, for `/healthz`, metrics and the log. Plain data."""

import logging
from collections import Counter
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

from dock_gateway.core.event import utc_now
from dock_gateway.observability.schema import HubState

log = logging.getLogger(__name__)


@dataclass
class HubLink:
    """The connection to the hub.

    Attributes:
        site: Name of this site.
        state: Whether the hub reaches it.
        changed_at: When that changed last.
        code: Why it does not: the hub's reason, or that of the connection; while it does, why its requests are refused,
            if this process has not accepted one yet; else None.
        detail: The same as a sentence.
        refused: Number of messages and identities that were refused here, by reason.
    """

    site: str
    state: HubState = HubState.UNREACHABLE
    changed_at: datetime = field(default_factory=utc_now)
    code: str | None = None
    detail: str | None = None
    refused: Counter[str] = field(default_factory=Counter)
    _believed: bool = False

    def connected(self, version: str) -> None:
        """Note that the hub takes this site."""
        if self.state is HubState.CONNECTED:
            return  # it stays so, with what `doubt` has noted
        if self._change(HubState.CONNECTED, None, None):
            log.info("connected to the hub as the site %s; the hub is dock-gateway %s", self.site, version)

    def refuse(self, code: str, detail: str) -> None:
        """Note that the hub does not take this site."""
        if self._change(HubState.REFUSED, code, detail):
            log.warning("the hub refuses the site %s: %s", self.site, detail)

    def lose(self, code: str, detail: str) -> None:
        """Note that the hub does not reach this site."""
        if self._change(HubState.UNREACHABLE, code, detail):
            log.warning("the hub does not reach the site %s, which works on without it: %s", self.site, detail)

    def believe(self) -> None:
        """Note that a request of the hub was accepted. Others may send what it has not signed: that says nothing."""
        if not self._believed and self.state is HubState.CONNECTED:
            self.code = self.detail = None
        self._believed = True

    def doubt(self, code: str, detail: str) -> None:
        """Note that a request was refused, unless one of the hub was accepted before: its key may be another one."""
        if not self._believed and self.state is HubState.CONNECTED and self._change(self.state, code, detail):
            log.warning("the requests of the hub are refused: %s", detail)

    def _change(self, state: HubState, code: str | None, detail: str | None) -> bool:
        """Set the state; return whether it is another one. A log has each reason once, until it is over."""
        changed = (state, code) != (self.state, self.code)
        if state is not self.state:
            self.changed_at = utc_now()
        self.state, self.code, self.detail = state, code, detail
        return changed

    def document(self) -> dict[str, Any]:
        """Return it as `/healthz` shows it."""
        return {
            "site": self.site,
            "state": self.state,
            "changed_at": self.changed_at,
            "code": self.code,
            "detail": self.detail,
        }
