"""The OpenID Connect provider, over HTTP: where it is, its keys, and what it says of a login."""

import asyncio
import logging
import re
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import quote_plus

import httpx2
import orjson

from dock_gateway import __version__
from dock_gateway.core.errors import NotAuthenticated, Unavailable
from dock_gateway.core.tasks import Tasks
from dock_gateway.extensions.single_sign_on.jwt import Keys, read_keys
from dock_gateway.extensions.single_sign_on.settings import SingleSignOnSettings, is_safe_address

log = logging.getLogger(__name__)

DISCOVERY = "/.well-known/openid-configuration"
# Seconds for one request with its whole answer.
TIMEOUT = 5.0
MAX_ANSWER = 262_144  # bytes
# Seconds between two reads of the provider while there are no logins, and after a read that failed.
INTERVAL, RETRY_INTERVAL = 600.0, 30.0
# Seconds for which what the provider said is recent enough for a new login, or for a key that is not known.
RECENT = 10.0
# Seconds after a failure in which others do not try again.
PAUSE = 2.0
# The code of an error of the provider (RFC 6749, 5.2). The rest is not repeated: anyone can have written it.
ERROR_CODE = re.compile(r"[a-z_]{1,40}")


@dataclass(frozen=True)
class ProviderEndpoints:
    """Addresses of the provider.

    Attributes:
        authorization: Where a browser is sent to log in.
        token: Where a code is redeemed.
        userinfo: Where more claims are; None if nowhere.
        end_session: Where a browser is sent to log out; None if nowhere.
        basic: Whether the client's secret goes into a header rather than into the body.
        names_itself: Whether it says in its redirects who it is (RFC 9207).
    """

    authorization: str
    token: str
    userinfo: str | None
    end_session: str | None
    basic: bool
    names_itself: bool


class Provider:
    """The provider's addresses and keys. Those that it gave earlier stay valid while it does not answer.

    Args:
        settings: Its settings.
        clock: Returns seconds that never go back.
        timeout: Seconds for one request with its whole answer.
    """

    def __init__(
        self, settings: SingleSignOnSettings, clock: Callable[[], float] = time.monotonic, *, timeout: float = TIMEOUT
    ) -> None:
        assert settings.oidc_issuer is not None
        self._timeout = timeout
        self.issuer = settings.oidc_issuer
        self.endpoints: ProviderEndpoints | None = None
        self.keys = Keys()
        self._client_id = settings.oidc_client_id
        secret = settings.oidc_client_secret
        self._secret = None if secret is None else secret.get_secret_value()
        self._clock = clock
        self._http: httpx2.AsyncClient | None = None
        self._refreshing = asyncio.Lock()
        self._looked_at = self._failed_at = float("-inf")
        self._failure = ""
        self._tasks = Tasks("asking the identity provider")

    def open(self) -> None:
        """Look at the provider now and from time to time. The gateway does not wait for it."""
        self._tasks.spawn(self._run())

    async def _run(self) -> None:
        while True:
            try:
                await self.refresh()
            except Unavailable:
                await asyncio.sleep(RETRY_INTERVAL)
            else:
                await asyncio.sleep(INTERVAL)

    async def close(self) -> None:
        """Close the connections."""
        await self._tasks.close()
        if self._http is not None:
            await self._http.aclose()

    async def refresh(self) -> ProviderEndpoints:
        """Read the addresses and the keys of the provider, unless they were read a moment ago.

        A request with an unknown key causes this, too, but not more often, and one at a time.

        Raises:
            Unavailable: It does not answer, or not as a provider does (`provider_unavailable`).
        """
        async with self._refreshing:
            now = self._clock()
            if self.endpoints is not None and now - self._looked_at < RECENT:
                return self.endpoints
            if now - self._failed_at < PAUSE:
                raise self._unavailable(self._failure)
            try:
                self.endpoints, self.keys = await self._read()
            except Unavailable as error:
                self._failed_at, self._failure = self._clock(), error.detail
                log.warning("%s", error.detail)
                raise
            self._looked_at = self._clock()
            return self.endpoints

    async def _read(self) -> tuple[ProviderEndpoints, Keys]:
        address = self.issuer.rstrip("/") + DISCOVERY
        document = await self._get(address)
        try:
            endpoints, keys_at = _read_endpoints(document, self.issuer)
            keys = read_keys(await self._get(keys_at))
        except ValueError as error:
            raise self._unavailable(f"what {address} says cannot be used: {error}") from None
        if not keys:
            raise self._unavailable("it has no key that can be used")
        return endpoints, keys

    async def redeem(self, code: str, verifier: str, redirect_uri: str) -> Mapping[str, Any]:
        """Return what a code stands for: `id_token`, `access_token`.

        Raises:
            NotAuthenticated: The code is not valid (`login_failed`).
            Unavailable: The provider does not answer (`provider_unavailable`).
        """
        endpoints = self.endpoints or await self.refresh()
        body = {
            "grant_type": "authorization_code",
            "code": code,
            "redirect_uri": redirect_uri,
            "code_verifier": verifier,
        }
        auth = None
        client_id, secret = self._client_id or "", self._secret
        if secret is not None and endpoints.basic:
            auth = httpx2.BasicAuth(quote_plus(client_id), quote_plus(secret))  # encoded: RFC 6749, 2.3.1
        else:
            body |= {"client_id": client_id} | ({} if secret is None else {"client_secret": secret})
        status, answer = await self._ask("POST", endpoints.token, data=body, auth=auth)
        if 200 <= status < 300:
            return answer
        reason = error_code(answer.get("error"))
        if status >= 500 or reason in ("invalid_client", "unauthorized_client"):
            log.warning("the identity provider does not redeem a code: %d %s", status, reason)
            raise self._unavailable(f"it answers {status} {reason}")
        raise NotAuthenticated(f"the identity provider refuses the login: {reason}", code="login_failed")

    async def user_info(self, access_token: str) -> Mapping[str, Any]:
        """Return more claims of the person who has this access token; none if the provider has none.

        Raises:
            Unavailable: The provider does not answer (`provider_unavailable`).
        """
        endpoints = self.endpoints or await self.refresh()
        if endpoints.userinfo is None:
            return {}
        return await self._get(endpoints.userinfo, {"Authorization": f"Bearer {access_token}"})

    async def _get(self, url: str, headers: Mapping[str, str] | None = None) -> Mapping[str, Any]:
        status, document = await self._ask("GET", url, headers=headers)
        if status != 200:
            raise self._unavailable(f"{url} answers {status}")
        return document

    async def _ask(
        self,
        method: str,
        url: str,
        headers: Mapping[str, str] | None = None,
        data: Mapping[str, str] | None = None,
        auth: httpx2.Auth | None = None,
    ) -> tuple[int, Mapping[str, Any]]:
        """Return the status and the JSON object that an address answers with."""
        if self._http is None:  # loads the machine's certificates, which takes time
            self._http = await asyncio.to_thread(_client)
        content = bytearray()
        try:
            async with (
                asyncio.timeout(self._timeout),
                self._http.stream(method, url, headers=headers, data=data, auth=auth) as answer,
            ):
                async for part in answer.aiter_raw():  # not unpacked: a small answer can be large then
                    content += part
                    if len(content) > MAX_ANSWER:
                        raise self._unavailable(f"{url} answers with more than {MAX_ANSWER} bytes")
                status = answer.status_code
            document = orjson.loads(content)
        except TimeoutError:
            raise self._unavailable(f"{url} does not answer within {TIMEOUT:g} s") from None
        except orjson.JSONDecodeError:
            raise self._unavailable(f"{url} answers {status}, not with JSON") from None
        except (httpx2.HTTPError, httpx2.InvalidURL, OSError, ValueError) as error:
            raise self._unavailable(f"{url} does not answer: {error or type(error).__name__}"[:300]) from None
        if not isinstance(document, dict):
            raise self._unavailable(f"{url} answers {status}, not with a JSON object")
        return status, document

    def _unavailable(self, reason: str) -> Unavailable:
        begin = "the identity provider is not available: "
        return Unavailable(begin + reason.removeprefix(begin), code="provider_unavailable", retry_after=5)


def error_code(value: object) -> str:
    """Return the code of an error of the provider, if it is one."""
    return value if isinstance(value, str) and ERROR_CODE.fullmatch(value) else "an error"


def _client() -> httpx2.AsyncClient:
    headers = {
        "Accept": "application/json",
        "Accept-Encoding": "identity",
        "User-Agent": f"dock-gateway/{__version__}",
    }
    return httpx2.AsyncClient(headers=headers, timeout=TIMEOUT, follow_redirects=False)


def _read_endpoints(document: Mapping[str, Any], issuer: str) -> tuple[ProviderEndpoints, str]:
    """Return the addresses of the provider, and that of its keys.

    Raises:
        ValueError: The document is of another provider, or lacks one.
    """
    if document.get("issuer") != issuer:
        raise ValueError(f"the issuer is {str(document.get('issuer'))[:200]!r}, not {issuer!r}")
    methods = document.get("token_endpoint_auth_methods_supported", ["client_secret_basic"])
    basic = not isinstance(methods, list) or "client_secret_basic" in methods or "client_secret_post" not in methods
    endpoints = ProviderEndpoints(
        authorization=_address(document, "authorization_endpoint"),
        token=_address(document, "token_endpoint"),
        userinfo=_optional_address(document, "userinfo_endpoint"),
        end_session=_optional_address(document, "end_session_endpoint"),
        basic=basic,
        names_itself=document.get("authorization_response_iss_parameter_supported") is True,
    )
    return endpoints, _address(document, "jwks_uri")


def _optional_address(document: Mapping[str, Any], name: str) -> str | None:
    return None if document.get(name) is None else _address(document, name)


def _address(document: Mapping[str, Any], name: str) -> str:
    value = document.get(name)
    if not isinstance(value, str) or not is_safe_address(value):
        raise ValueError(f"{name} is missing, or not at https")
    return value
