"""Sends one event to a webhook, signed as Standard Webhooks specify (standardwebhooks.com)."""

import asyncio
import base64
import binascii
import hashlib
import hmac
import secrets
from collections.abc import Mapping
from datetime import datetime
from http import HTTPStatus
from http.cookiejar import CookieJar, DefaultCookiePolicy

import httpx2

from dock_gateway import __version__
from dock_gateway.core.goal import Json
from dock_gateway.extensions.webhooks.policy import ReceiverAnswer

SECRET_PREFIX = "whsec_"  # noqa: S105 - a prefix, not a secret
MIN_SECRET, MAX_SECRET = 24, 64  # bytes
# Seconds for the connection, the request and the beginning of the answer together.
TIMEOUT = 10.0


def new_secret() -> str:
    """Return a random secret."""
    return SECRET_PREFIX + base64.b64encode(secrets.token_bytes(32)).decode()


def is_secret(text: str) -> bool:
    """Return whether a text is `whsec_` and 24 to 64 bytes in base64."""
    try:
        return text.startswith(SECRET_PREFIX) and MIN_SECRET <= len(_key(text)) <= MAX_SECRET
    except (binascii.Error, ValueError):
        return False


def _key(secret: str) -> bytes:
    return base64.b64decode(secret.removeprefix(SECRET_PREFIX), validate=True)


def sign(secret: str, identity: str, at: datetime, body: Json) -> Mapping[str, str]:
    """Return the headers that identify and sign an event.

    Args:
        secret: The secret of the webhook.
        identity: The id of the event: the same for each attempt.
        at: The time of the attempt.
        body: The event, as it is sent.
    """
    seconds = str(int(at.timestamp()))
    content = b".".join((identity.encode(), seconds.encode(), body))
    digest = hmac.new(_key(secret), content, hashlib.sha256).digest()
    return {
        "webhook-id": identity,
        "webhook-timestamp": seconds,
        "webhook-signature": f"v1,{base64.b64encode(digest).decode()}",
    }


class Sender:
    """Sends events over HTTP. Redirects are not followed, the body of an answer is not read, and no cookie is kept.

    Args:
        timeout: Seconds that an attempt may take.
    """

    def __init__(self, timeout: float = TIMEOUT) -> None:
        self._timeout = timeout
        self._http: httpx2.AsyncClient | None = None

    async def send(self, url: str, headers: Mapping[str, str], body: Json) -> ReceiverAnswer:
        """Send an event, and return what came of it. Never raises."""
        try:
            if self._http is None:  # loads the machine's certificates, which takes time
                self._http = await asyncio.to_thread(_client, self._timeout)
            async with (
                asyncio.timeout(self._timeout),
                self._http.stream("POST", url, content=body, headers=dict(headers)) as answer,
            ):
                status = answer.status_code
        except TimeoutError:
            return ReceiverAnswer(None, f"no answer within {self._timeout:g} s")
        except (httpx2.HTTPError, httpx2.InvalidURL, OSError, ValueError) as error:
            return ReceiverAnswer(None, f"no connection: {error or type(error).__name__}"[:200])
        if HTTPStatus(200) <= status < HTTPStatus(300):
            return ReceiverAnswer(status, None)
        return ReceiverAnswer(status, f"the answer was {status}")

    async def close(self) -> None:
        """Close the connections."""
        if self._http is not None:
            await self._http.aclose()


def _client(timeout: float) -> httpx2.AsyncClient:
    headers = {"Content-Type": "application/json", "User-Agent": f"dock-gateway/{__version__}"}
    cookies = CookieJar(DefaultCookiePolicy(allowed_domains=()))  # accepts none
    return httpx2.AsyncClient(headers=headers, cookies=cookies, timeout=timeout, follow_redirects=False)
