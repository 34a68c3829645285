"""Delays logins after failed ones. Pure: the clock is given."""

from collections import OrderedDict
from dataclasses import dataclass
from ipaddress import IPv6Address, ip_address
from typing import Any

# A name at a place, which is an address or a browser; a name at all places; or an address.
Key = tuple[str | None, str | None]

# Those who show no name, and what stands before the name of a user who changes the password: someone who logs in fails
# elsewhere. Upper case, so that no user has these names.
TOKENS, PEOPLE, CHANGE = "TOKENS", "PEOPLE", "CHANGE "

# Seconds after which failures are forgotten.
FORGET = 3600.0
# Maximum number of names and addresses that are remembered, of each kind.
MAX_REMEMBERED = 10_000
# Doublings of the delay; more would only make the numbers larger.
MAX_DOUBLINGS = 20


@dataclass(frozen=True)
class Slope:
    """The growth of a delay: 1 s, then twice as long after each failure.

    Attributes:
        free: Number of failures without a delay.
        longest: The longest delay in seconds.
    """

    free: int
    longest: float

    def delay(self, failures: int) -> float:
        """Return the seconds from the last of some failures to the next attempt."""
        if failures <= self.free:
            return 0.0
        return min(self.longest, 2.0 ** min(failures - self.free - 1, MAX_DOUBLINGS))


# For a name at an address, or in a known browser.
PAIR = Slope(4, 300.0)
# For a name at an address from which it has logged in before.
KNOWN = Slope(100, 300.0)
# For all names at an address.
ADDRESS = Slope(20, 300.0)
# For a name at all addresses.
NAME = Slope(20, 10.0)


@dataclass
class Failures:
    """Failed attempts; the last was at `at`."""

    count: int = 0
    at: float = 0.0


class LoginDelays:
    """The failed logins of the last hour, by name and address.

    An attempt counts as failed until it succeeds, so that many at the same time are no way around. A name is delayed
    only by its own failures where it has logged in before: by those in that very browser; and from that address, where
    someone else may try too, by many. So a user cannot be locked out of their usual place.
    """

    def __init__(self) -> None:
        self._failures: OrderedDict[Key, Failures] = OrderedDict()
        self._known: OrderedDict[Key, None] = OrderedDict()

    def __len__(self) -> int:
        return max(len(self._failures), len(self._known))

    def attempt(self, name: str, address: str, now: float, browser: str | None = None) -> float:
        """Count an attempt and return 0.0, or return the seconds to wait; then it must not be made.

        Args:
            name: The user's name, `TOKENS` or `PEOPLE`.
            address: The client's address.
            now: Seconds of a clock that never goes back.
            browser: The id of the browser, if the name has logged in there before.
        """
        slopes = self._slopes(name, address, browser)
        wait = max(self._wait(key, slope, now) for key, slope in slopes.items() if slope is not None)
        if wait > 0.0:
            return wait
        for key in slopes:
            failures = self._failures.setdefault(key, Failures())
            failures.count += 1
            failures.at = now
            self._failures.move_to_end(key)
        _shorten(self._failures)
        return 0.0

    def succeed(self, name: str, address: str, browser: str | None = None) -> None:
        """Forget the failures of a name, and the attempt that was counted for the address."""
        self.withdraw(name, address, browser)
        for key in ((name, _place(address, browser)), (name, None)):
            self._failures.pop(key, None)
        self._known[name, address] = None
        self._known.move_to_end((name, address))
        _shorten(self._known)

    def withdraw(self, name: str, address: str, browser: str | None = None) -> None:
        """Forget an attempt that neither failed nor succeeded."""
        for key in self._slopes(name, address, browser):
            failures = self._failures.get(key)
            if failures is not None:
                failures.count -= 1
                if failures.count <= 0:
                    del self._failures[key]

    def _slopes(self, name: str, address: str, browser: str | None) -> dict[Key, Slope | None]:
        """Return where an attempt counts, and by what it is delayed there; None: it is not."""
        usual = browser is not None or (name, address) in self._known
        own = KNOWN if usual and browser is None else PAIR
        slopes: dict[Key, Slope | None] = {
            (name, _place(address, browser)): own,
            (None, address): None if usual else ADDRESS,
        }
        if name not in (TOKENS, PEOPLE):
            slopes[name, None] = None if usual else NAME
        return slopes

    def _wait(self, key: Key, slope: Slope, now: float) -> float:
        failures = self._failures.get(key)
        if failures is None:
            return 0.0
        if now - failures.at > FORGET:
            del self._failures[key]
            return 0.0
        return max(0.0, failures.at + slope.delay(failures.count) - now)


def _place(address: str, browser: str | None) -> str:
    return address if browser is None else f"browser {browser}"


def _shorten(remembered: OrderedDict[Key, Any]) -> None:
    while len(remembered) > MAX_REMEMBERED:
        remembered.popitem(last=False)


def network_of(address: str) -> str:
    """Return what a client cannot easily change of its address: of IPv6, the first 64 bits."""
    try:
        parsed = ip_address(address.partition("%")[0])
    except ValueError:
        return address
    if not isinstance(parsed, IPv6Address):
        return str(parsed)
    if parsed.ipv4_mapped is not None:
        return str(parsed.ipv4_mapped)
    return str(IPv6Address(int(parsed) >> 64 << 64))
