"""The logins of people and services of the identity provider, as far as the gateway keeps them."""

from collections.abc import Callable, Mapping
from typing import Any

from dock_gateway.access.login_delays import PEOPLE
from dock_gateway.access.login_guard import LoginGuard
from dock_gateway.access.login_source import LoginPage
from dock_gateway.access.sessions import MAX_SESSIONS
from dock_gateway.core.access import Principal, PrincipalKind
from dock_gateway.extensions.single_sign_on import claims, people
from dock_gateway.extensions.single_sign_on.jwt import looks_like_jwt
from dock_gateway.extensions.single_sign_on.login_attempt import LoginAttempt
from dock_gateway.extensions.single_sign_on.people import PersonSession, PersonSessions
from dock_gateway.extensions.single_sign_on.single_sign_on import SingleSignOn, without_provider
from dock_gateway.storage import History
from dock_gateway.storage.shared_entries import SharedBook


class ProviderLogins:
    """Who has logged in at the provider: a `LoginSource` of the gateway.

    Args:
        history: Stores the sessions of people.
        guard: Counts failed logins.
        sso: The provider; None if the settings have none. Then no one is logged in.
    """

    prefix = claims.PREFIX

    def __init__(self, history: History, guard: LoginGuard, sso: SingleSignOn | None) -> None:
        book = SharedBook(history.documents("person_session", PersonSession), "session", MAX_SESSIONS)
        self.people = PersonSessions(book, None if sso is None else sso.issuer)
        self.sso = sso
        self._guard = guard

    async def open(self) -> None:
        """Read who is logged in, and ask the provider from time to time."""
        await self.refresh()
        if self.sso is not None:
            self.sso.provider.open()

    async def close(self) -> None:
        """Ask the provider no longer."""
        if self.sso is not None:
            await self.sso.provider.close()

    # ------------------------------------------------------------------ who shows a secret

    @property
    def page(self) -> LoginPage | None:
        """The provider, if people log in there."""
        if self.sso is None or self.sso.client_id is None:
            return None
        return LoginPage(self.sso.name, self.sso.logout_url)

    def reads(self, secret: str) -> bool:
        """Return whether a secret is that of a person's session, or an access token."""
        return secret.startswith(people.PREFIX) or (self.sso is not None and looks_like_jwt(secret))

    async def prepare(self, secret: str) -> None:
        """Ask the provider for the key of an access token.

        Raises:
            Unavailable: It has not answered yet since the gateway was started (`provider_unavailable`).
        """
        if self.sso is not None and not secret.startswith(people.PREFIX):
            await self.sso.prepare(secret)

    def identify(self, secret: str) -> Principal:
        """Return who shows a secret.

        Raises:
            NotAuthenticated: It is not valid (`invalid_token`).
            NotAllowed: It is an access token whose claims give no role (`role_required`).
        """
        if self.sso is None or secret.startswith(people.PREFIX):
            return self.people.identify(secret)
        return self.sso.identify(secret)

    def is_valid(self, principal: Principal) -> bool:
        """Return whether a person is still logged in, or the access token of a service is still valid."""
        if principal.kind is PrincipalKind.SERVICE:
            return self.sso is not None and self.sso.is_valid(principal)
        return principal.credential is not None and self.people.principal(principal.credential) == principal

    async def log_out(self, secret: str) -> None:
        """End the session of a person, if the secret is one's.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`); the session goes on.
        """
        await self.people.end(secret)

    async def log_out_everywhere(self, name: str) -> None:
        """End all sessions of a person.

        Raises:
            NotFound: The person has none (`person_not_found`).
            Unavailable: The history does not answer (`history_unavailable`); some go on.
        """
        await self.people.end_all(name)

    async def refresh(self) -> None:
        """Read changes of other gateways, and delete sessions that have ended."""
        await self.people.refresh()
        await self.people.sweep()

    # ------------------------------------------------------------------ the login of a person

    async def begin(self, page: str, redirect_uri: str) -> tuple[str, LoginAttempt]:
        """Begin a login with the provider, as `SingleSignOn.begin` does."""
        return await self._require_sso().begin(page, redirect_uri)

    async def log_in(
        self,
        attempt: LoginAttempt | None,
        said: Mapping[str, str],
        redirect_uri: str,
        address: str,
        note: Callable[[str], None] = lambda _: None,
    ) -> tuple[Principal, str]:
        """Log a person in whom the provider has sent back; return who that is, and the secret of the session.

        Args:
            attempt: What the browser has kept of the login.
            said: The query with which the provider has sent it back.
            redirect_uri: The address without the query.
            address: The client's address.
            note: Is given the name of the person and the provider's id, also if they are refused then.

        Raises:
            NotFound: People do not log in here with a provider (`provider_not_found`).
            NotAuthenticated: The login is not valid (`login_failed`).
            NotAllowed: The person has no role (`role_required`).
            Conflict: There are too many sessions (`limit_reached`).
            TooManyRequests: There were too many failed logins (`too_many_logins`).
            Unavailable: The provider (`provider_unavailable`) or the history (`history_unavailable`) does not answer.
        """
        sso = self._require_sso()
        code, attempt = sso.accept(attempt, said)  # not counted: any page can make a browser fail here
        with self._guard.counted(PEOPLE, address):
            person = await sso.redeem(code, attempt, redirect_uri)
            note(f"{person.name} ({person.subject})")
            grant = sso.grant_of(person)
            secret = await self.people.create(person.name, person.subject, grant, person.attempt, sso.lifetime)
        return self.people.identify(secret), secret

    async def documents(self) -> list[dict[str, Any]]:
        """Return the people who are logged in by name, as the API shows them.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`).
        """
        return await self.people.documents()

    def _require_sso(self) -> SingleSignOn:
        if self.sso is None:
            raise without_provider()
        return self.sso
