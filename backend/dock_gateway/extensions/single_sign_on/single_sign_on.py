"""Logins at an identity provider: of people in a browser, and access tokens of services."""

import secrets
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import timedelta
from typing import Any
from urllib.parse import urlencode, urlsplit

from dock_gateway.access.credentials import ID_DIGITS, digest_of
from dock_gateway.core.access import Principal, PrincipalKind
from dock_gateway.core.errors import NotAuthenticated, NotFound, Unavailable
from dock_gateway.core.event import utc_now
from dock_gateway.core.grant import Grant
from dock_gateway.extensions.single_sign_on.claims import ClaimRules, Claims, find_claim, subject_of
from dock_gateway.extensions.single_sign_on.jwt import (
    check_claims,
    read_header,
    read_unverified,
    require_access_token,
    verify,
)
from dock_gateway.extensions.single_sign_on.login_attempt import LIFETIME, LoginAttempt
from dock_gateway.extensions.single_sign_on.provider import Provider, error_code
from dock_gateway.extensions.single_sign_on.settings import SingleSignOnSettings

# How many used states are remembered until they expire.
MAX_USED = 10_000
MAX_CODE = 4096


@dataclass(frozen=True)
class ProviderUser:
    """Someone who has logged in at the provider.

    Attributes:
        name: How records name them, `oidc:…`.
        subject: The provider's id of them.
        attempt: Digest of the state of the login.
        claims: What the provider says of them.
    """

    name: str
    subject: str
    attempt: str
    claims: Claims


class SingleSignOn:
    """An identity provider as the settings describe it.

    Args:
        settings: Of them, those of the provider.
        provider: Asks it.
        clock: Returns seconds since 1970.
    """

    def __init__(
        self, settings: SingleSignOnSettings, provider: Provider | None = None, clock: Callable[[], float] = time.time
    ) -> None:
        assert settings.oidc_issuer is not None
        self.provider = provider or Provider(settings)
        self.rules = ClaimRules(settings)
        self.issuer = settings.oidc_issuer
        self.name = settings.oidc_name or urlsplit(self.issuer).hostname or self.issuer
        self.lifetime = timedelta(hours=settings.oidc_session_hours)
        self.client_id, self.audience = settings.oidc_client_id, settings.oidc_audience
        self._scopes = settings.oidc_scopes
        self._algorithms = settings.oidc_algorithms
        self._clock = clock
        self._used: OrderedDict[str, float] = OrderedDict()

    @property
    def logout_url(self) -> str | None:
        """The address where a person logs out at the provider, if there is one."""
        endpoints = self.provider.endpoints
        if endpoints is None or endpoints.end_session is None or self.client_id is None:
            return None
        return _with_query(endpoints.end_session, {"client_id": self.client_id})

    # ------------------------------------------------------------------ people

    async def begin(self, page: str, redirect_uri: str) -> tuple[str, LoginAttempt]:
        """Begin a login; return where the browser has to go.

        Args:
            page: Where the browser goes in the end.
            redirect_uri: Where the provider sends it before.

        Raises:
            NotFound: People do not log in here with a provider (`provider_not_found`).
            Unavailable: The provider does not answer (`provider_unavailable`).
        """
        client_id = self._require_client()
        endpoints = await self.provider.refresh()
        attempt = LoginAttempt.begin(page, self._clock())
        asked = {
            "response_type": "code",
            "client_id": client_id,
            "redirect_uri": redirect_uri,
            "scope": self._scopes,
            "state": attempt.state,
            "nonce": attempt.nonce,
            "code_challenge": attempt.challenge,
            "code_challenge_method": "S256",
        }
        return _with_query(endpoints.authorization, asked), attempt

    def accept(self, attempt: LoginAttempt | None, said: Mapping[str, str]) -> tuple[str, LoginAttempt]:
        """Return the code for a login that this browser has begun, which is used up then.

        Args:
            attempt: What the browser has kept.
            said: The query with which the provider has sent it back.

        Raises:
            NotFound: People do not log in here with a provider (`provider_not_found`).
            NotAuthenticated: The browser has not begun this login, or it was used or has expired, or the provider
                refuses it (`login_failed`).
        """
        self._require_client()
        if attempt is None or not attempt.has_state(said.get("state")):
            raise _failure("this browser has not begun it, or has begun another one since")
        if attempt.expired(self._clock()):
            raise _failure(f"it took longer than {LIFETIME // 60} minutes")
        self._use_up(attempt)
        self._check_sender(said)
        if "error" in said:
            raise _failure(f"the identity provider refuses it: {error_code(said['error'])}")
        code = said.get("code", "")
        if not 0 < len(code) <= MAX_CODE:
            raise _failure("the identity provider has sent no code")
        return code, attempt

    async def redeem(self, code: str, attempt: LoginAttempt, redirect_uri: str) -> ProviderUser:
        """Return who has logged in.

        Args:
            code: The code, as `accept` returns it.
            attempt: The login.
            redirect_uri: As in `begin`.

        Raises:
            NotAuthenticated: The code or the provider's answer is not valid (`login_failed`).
            Unavailable: The provider does not answer (`provider_unavailable`).
        """
        client_id = self._require_client()
        claims = await self._redeem(code, attempt, redirect_uri, client_id)
        return ProviderUser(self.rules.name_of(claims), subject_of(claims), digest_of(attempt.state), claims)

    def _require_client(self) -> str:
        if self.client_id is None:
            raise without_provider()
        return self.client_id

    def _check_sender(self, said: Mapping[str, str]) -> None:
        """Refuse an answer that another provider has sent (RFC 9207)."""
        endpoints = self.provider.endpoints
        needed = endpoints is not None and endpoints.names_itself
        if said.get("iss", None if needed else self.issuer) != self.issuer:
            raise _failure("another identity provider has answered")

    def _use_up(self, attempt: LoginAttempt) -> None:
        digest = digest_of(attempt.state)
        now = self._clock()
        while self._used and (len(self._used) >= MAX_USED or next(iter(self._used.values())) <= now):
            self._used.popitem(last=False)
        if digest in self._used:
            raise _failure("it was used already")
        self._used[digest] = now + LIFETIME

    async def _redeem(self, code: str, attempt: LoginAttempt, redirect_uri: str, client_id: str) -> Claims:
        answer = await self.provider.redeem(code, attempt.verifier, redirect_uri)
        token, access_token = answer.get("id_token"), answer.get("access_token")
        if not isinstance(token, str):
            raise _failure("the identity provider has sent no ID token")
        try:
            await self._learn_key(token)
            claims = verify(token, self.provider.keys, self._algorithms).claims
            check_claims(claims, self.issuer, client_id, utc_now())
        except NotAuthenticated as error:
            raise _failure(error.detail.replace("the access token", "the ID token")) from None
        if claims.get("azp", client_id) != client_id:
            raise _failure("the ID token is for another client")
        if not secrets.compare_digest(str(claims.get("nonce")).encode(errors="replace"), attempt.nonce.encode()):
            raise _failure("the ID token is for another login")
        if isinstance(access_token, str) and any(find_claim(claims, name) is None for name in self.rules.needed):
            more = await self.provider.user_info(access_token)
            if more and more.get("sub") != subject_of(claims):
                raise _failure("the identity provider has answered about another person")
            claims = {**more, **claims}
        return claims

    # ------------------------------------------------------------------ services

    async def prepare(self, token: str) -> None:
        """Ask the provider for the key of an access token, if that is not known and may be new.

        Raises:
            Unavailable: The provider has not answered yet since the gateway was started (`provider_unavailable`).
        """
        if self.audience is None:
            return
        try:
            claims = read_unverified(token)
            check_claims(claims, self.issuer, self.audience, utc_now())
            await self._learn_key(token)
        except NotAuthenticated:
            pass  # `identify` refuses it
        except Unavailable:
            if not self.provider.keys:
                raise

    async def _learn_key(self, token: str) -> None:
        header = read_header(token)
        if header.algorithm in self._algorithms and self.provider.keys.find(header) is None:
            await self.provider.refresh()

    def identify(self, token: str) -> Principal:
        """Return who shows an access token.

        Raises:
            NotAuthenticated: It is not valid (`invalid_token`).
            NotAllowed: Its claims give no role (`role_required`).
        """
        if self.audience is None:
            raise NotAuthenticated(
                "access tokens are not accepted here: oidc_audience is not set", code="invalid_token"
            )
        signed = verify(token, self.provider.keys, self._algorithms)
        expires_at = check_claims(signed.claims, self.issuer, self.audience, utc_now())
        require_access_token(read_header(token), signed.claims, self.client_id)
        try:
            subject_of(signed.claims)
            name = self.rules.name_of(signed.claims)
        except NotAuthenticated as error:
            raise NotAuthenticated(error.detail, code="invalid_token") from None
        grant = self.rules.grant_of(signed.claims)
        return Principal(name, PrincipalKind.SERVICE, grant, digest_of(token)[:ID_DIGITS], expires_at, signed.key)

    def is_valid(self, principal: Principal) -> bool:
        """Return whether an access token that was valid still is."""
        assert principal.expires_at is not None
        return utc_now() < principal.expires_at and principal.key in self.provider.keys

    def grant_of(self, person: ProviderUser) -> Grant:
        """Return what a person may do.

        Raises:
            NotAllowed: They have no role (`role_required`).
        """
        return self.rules.grant_of(person.claims)


def without_provider() -> NotFound:
    """Return the error that people do not log in here with an identity provider."""
    return NotFound("this gateway has no identity provider", code="provider_not_found")


def _failure(reason: str) -> NotAuthenticated:
    return NotAuthenticated(f"the login has failed: {reason}", code="login_failed")


def _with_query(address: str, query: Mapping[str, Any]) -> str:
    return f"{address}{'&' if '?' in address else '?'}{urlencode(query)}"
