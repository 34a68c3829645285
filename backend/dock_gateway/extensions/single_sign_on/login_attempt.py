"""A login at the provider that is under way. Pure: the time is given.

Nothing of it is stored: the browser keeps it in a cookie, and what the provider gets is derived from that. So a login
cannot be finished without the cookie, a change of the cookie changes everything else, and logins that are not finished
cost nothing.
"""

import base64
import hashlib
import hmac
import re
import secrets
from dataclasses import dataclass

# Seconds that a person may take to log in at the provider.
LIFETIME = 600
MAX_PAGE = 500
# Where the browser may go then: a page of the dashboard, also that of a site. No other host, no backslash:
# browsers take it for a slash.
PAGE = re.compile(r"(?:/sites/[a-z][a-z0-9_]{0,39})?/(?:ui/[!\"$-\[\]-~]*)?")
_COOKIE = re.compile(r"([0-9]{1,12})\.([A-Za-z0-9_-]{43})\.([A-Za-z0-9_-]*)")


def is_page(text: str) -> bool:
    """Return whether a text is the address of a page of the dashboard."""
    return len(text) <= MAX_PAGE and bool(PAGE.fullmatch(text))


@dataclass(frozen=True)
class LoginAttempt:
    """A login that has begun.

    Attributes:
        started: When, in seconds since 1970.
        secret: 256 random bits.
        page: Where the browser goes then.
    """

    started: int
    secret: str
    page: str

    @classmethod
    def begin(cls, page: str, now: float) -> "LoginAttempt":
        """Begin a login."""
        return cls(int(now), secrets.token_urlsafe(32), page)

    @classmethod
    def read(cls, cookie: str | None) -> "LoginAttempt | None":
        """Return the login in a cookie; None if there is none."""
        match = _COOKIE.fullmatch(cookie or "")
        if match is None:
            return None
        try:
            page = base64.urlsafe_b64decode(match[3] + "=" * (-len(match[3]) % 4)).decode("ascii")
        except ValueError:
            return None
        return cls(int(match[1]), match[2], page) if is_page(page) else None

    @property
    def cookie(self) -> str:
        """The value of the browser's cookie."""
        return f"{self.started}.{self.secret}.{_text(self.page.encode())}"

    @property
    def state(self) -> str:
        """The value that the provider sends back: shows that this browser has begun the login (RFC 6749, 10.12)."""
        return self._derive("state")

    @property
    def nonce(self) -> str:
        """The value that the ID token has to contain: shows that it is for this login."""
        return self._derive("nonce")

    @property
    def verifier(self) -> str:
        """The secret that redeems the code (RFC 7636)."""
        return self._derive("verifier")

    @property
    def challenge(self) -> str:
        """The SHA-256 of the verifier, which the provider gets beforehand."""
        return _text(hashlib.sha256(self.verifier.encode()).digest())

    def expired(self, now: float) -> bool:
        """Return whether the person took too long, or the clock is wrong."""
        return not -LIFETIME < now - self.started < LIFETIME

    def has_state(self, state: str | None) -> bool:
        """Return whether a state is that of this login."""
        return hmac.compare_digest(self.state.encode(), (state or "").encode(errors="replace"))

    def _derive(self, purpose: str) -> str:
        said = f"{purpose} {self.started} {self.page}"
        return _text(hmac.digest(self.secret.encode(), said.encode(), "sha256"))


def _text(data: bytes) -> str:
    return base64.urlsafe_b64encode(data).rstrip(b"=").decode()
