"""Identifies who makes a request of the hub, with what they may do at this site."""

import time
from collections.abc import Callable

from dock_gateway.core.access import Principal, forwarded
from dock_gateway.core.errors import NotAuthenticated
from dock_gateway.core.grant import Role
from dock_gateway.extensions.sites.link import HubLink
from dock_gateway.extensions.sites.settings import SiteSettings
from dock_gateway.sites.identity import AGREEMENT, NOTHING, IdentityReused, Verifier


class HubAdmission:
    """Lets in what the hub has signed, with at most the role and the robots that the settings allow it.

    Args:
        settings: The settings of a site.
        instance: This process.
        link: Records whether the hub is trusted.
        clock: Returns the time in seconds since 1970.

    Raises:
        KeyFault: The file with the hub's keys cannot be used.
    """

    def __init__(
        self, settings: SiteSettings, instance: str, link: HubLink, clock: Callable[[], float] = time.time
    ) -> None:
        assert settings.hub_public_keys is not None
        self._verifier = Verifier(settings.hub_public_keys, settings.site)
        self._limits = Role(settings.hub_role), settings.hub_robots
        self._instance = instance
        self._link = link
        self._clock = clock

    def __call__(self, token: str, method: str, path: str, content: str = NOTHING) -> Principal:
        """Return who makes a request.

        Args:
            token: What the hub has signed.
            method: The request's method.
            path: Its path, without the query.
            content: Its query and its body, as `content_of` has them.

        Raises:
            NotAuthenticated: The hub has not signed it, or it is late (`invalid_identity`); or it was received already
                (`identity_reused`).
            TooManyRequests: The hub has sent too many requests in the last minute.
        """
        try:
            said = self._verifier.verify(token, self._instance, method, path, self._clock(), content)
        except IdentityReused:
            raise
        except NotAuthenticated as error:
            self._link.doubt(error.code, error.detail)
            raise
        self._link.believe()
        return forwarded(said.name, said.grant.narrowed(*self._limits), said.key)

    def confirm(self, proof: str, public: str, hub_public: str) -> None:
        """Check that the hub has a public key.

        Args:
            proof: What the hub has signed.
            public: The public key of this process.
            hub_public: That of the hub.

        Raises:
            NotAuthenticated: It has not signed that.
        """
        self._verifier.verify(proof, self._instance, AGREEMENT, hub_public, self._clock(), public)
