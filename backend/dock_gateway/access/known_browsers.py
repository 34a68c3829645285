"""Browsers in which a user has logged in before. A cookie shows that; nothing is stored. Pure.

The cookie has a random id, and for each user of the browser a signature that only this user's entry in the database can
make. It is no login. It ends with a new password, and with all sessions of the user.
"""

import hashlib
import hmac
import re
import secrets
from base64 import urlsafe_b64encode

from dock_gateway.core.access import User

# Maximum number of users that one browser is known for.
MAX_USERS = 8
# Random bytes of the id, and bytes of a signature.
BYTES = 16
COOKIE = re.compile(r"[A-Za-z0-9_-]{22}(\.[A-Za-z0-9_-]{22})*")


def browser_of(cookie: str | None, name: str, user: User | None) -> str | None:
    """Return the id of the browser with this cookie if the user has logged in there before.

    Args:
        cookie: What the browser sends.
        name: The user's name.
        user: The user; None if there is none, which takes as long.
    """
    browser, signatures = _read(cookie)
    expected = _sign(browser, name, user)
    found = [hmac.compare_digest(expected, each) for each in signatures]
    return browser if any(found) and user is not None else None


def remember(cookie: str | None, name: str, user: User) -> str:
    """Return the cookie of a browser in which a user has logged in, which may have one already."""
    browser, signatures = _read(cookie)
    own = _sign(browser, name, user)
    return ".".join([browser, own, *(each for each in signatures if each != own)][: 1 + MAX_USERS])


def _read(cookie: str | None) -> tuple[str, list[str]]:
    """Return the id and the signatures of a cookie; a new id if it is none."""
    if cookie is None or not COOKIE.fullmatch(cookie):
        return _text(secrets.token_bytes(BYTES)), []
    browser, *signatures = cookie.split(".")
    return browser, signatures[:MAX_USERS]


def _sign(browser: str, name: str, user: User | None) -> str:
    key = secrets.token_bytes(BYTES) if user is None else f"{user.password} {user.era}".encode()
    return _text(hmac.digest(key, f"{browser} {name}".encode(errors="surrogatepass"), hashlib.sha256)[:BYTES])


def _text(data: bytes) -> str:
    return urlsafe_b64encode(data).decode().rstrip("=")
