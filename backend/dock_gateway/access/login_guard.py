"""Bounds how often one may try to log in."""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from dock_gateway.access.known_browsers import browser_of, remember
from dock_gateway.access.login_delays import LoginDelays, network_of
from dock_gateway.core.access import User
from dock_gateway.core.errors import NotAllowed, NotAuthenticated, TooManyRequests


class LoginGuard:
    """Delays logins after failed ones, and knows the browsers of users again.

    Args:
        find: Returns a user by name, if there is one.
    """

    def __init__(self, find: Callable[[str], User | None]) -> None:
        self._find = find
        self._delays = LoginDelays()

    @contextmanager
    def counted(self, name: str, address: str, cookie: str | None = None) -> Iterator[None]:
        """Refuse an attempt that comes too soon after failed ones, and count it if it fails.

        Args:
            name: The user's name, or one of those that `login_delays` has for logins without one.
            address: The client's address.
            cookie: The cookie of `known_cookie`, if the client has one.

        Raises:
            TooManyRequests: It does (`too_many_logins`).
        """
        network, browser = network_of(address), browser_of(cookie, name, self._find(name))
        wait = math.ceil(self._delays.attempt(name, network, time.monotonic(), browser))
        if wait > 0:
            detail = f"too many failed logins; try again in {wait} s"
            raise TooManyRequests(detail, code="too_many_logins", retry_after=wait)
        try:
            yield
        except (NotAuthenticated, NotAllowed):
            raise
        except BaseException:
            self._delays.withdraw(name, network, browser)
            raise
        self._delays.succeed(name, network, browser)

    def known_cookie(self, name: str, cookie: str | None) -> str | None:
        """Return the cookie by which the browser of a user who has just logged in is known from now on.

        Args:
            name: The user's name.
            cookie: The one that the browser has, if it has one.
        """
        user = self._find(name)
        return None if user is None else remember(cookie, name, user)
