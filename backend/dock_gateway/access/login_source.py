"""What says who makes a request besides the gateway's own users and tokens, such as an identity provider."""

from typing import NamedTuple, Protocol

from dock_gateway.core.access import Principal


class LoginPage(NamedTuple):
    """Where people log in elsewhere.

    Attributes:
        name: What the login page of the dashboard calls it.
        logout_url: Its own page for logging out, if it has one.
    """

    name: str
    logout_url: str | None


class LoginSource(Protocol):
    """Says who shows a secret, such as an access token. An extension adds one to `Logins.sources`.

    A principal that it identifies is of the kind `person` or `service`.

    Attributes:
        prefix: What the names of its people and services begin with. No token of the gateway has such a name.
    """

    prefix: str

    @property
    def page(self) -> LoginPage | None:
        """Where people log in; None if they do not."""

    def reads(self, secret: str) -> bool:
        """Return whether a secret is one of its own, valid or not."""

    async def prepare(self, secret: str) -> None:
        """Ask elsewhere for what `identify` needs to know.

        Raises:
            Unavailable: There is no answer, and nothing is known from before.
        """

    def identify(self, secret: str) -> Principal:
        """Return who shows a secret.

        Raises:
            NotAuthenticated: It is not valid (`invalid_token`).
            NotAllowed: They have no role (`role_required`).
        """

    def is_valid(self, principal: Principal) -> bool:
        """Return whether someone whom it has identified is still logged in, with the same rights."""

    async def log_out(self, secret: str) -> None:
        """End a session.

        Raises:
            Unavailable: The history does not answer (`history_unavailable`); the session goes on.
        """

    async def log_out_everywhere(self, name: str) -> None:
        """End all sessions of a person.

        Raises:
            NotFound: The person has none.
            Unavailable: The history does not answer (`history_unavailable`); some go on.
        """

    async def refresh(self) -> None:
        """Read changes of other gateways."""
