"""An identity provider for tests: signs what it is told to, answers as badly as it is told to, and can be away."""

import asyncio
import base64
import hashlib
import os
import re
import sys
import threading
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import parse_qs, parse_qsl, urlsplit

import httpx2
import orjson
from joserfc import jws
from joserfc.jwk import ECKey, OctKey, OKPKey, RSAKey

from dock_gateway.extensions.single_sign_on.jwt import Registry
from tests.support.processes import Process

ISSUER = "https://login.example"
CLIENT, AUDIENCE = "dashboard", "https://robots.example"

Key = RSAKey | ECKey | OKPKey


def rsa_key(kid: str | None) -> RSAKey:
    return RSAKey.generate_key(2048, {"kid": kid} if kid else None)


def encode(part: Any) -> str:
    data = part if isinstance(part, bytes) else orjson.dumps(part)
    return base64.urlsafe_b64encode(data).rstrip(b"=").decode()


def sign(key: Key | OctKey, claims: Any, algorithm: str = "RS256", **header: Any) -> str:
    """A JWT: with the key's id, unless the header says something else. Claims may be JSON text already."""
    fields = {"alg": algorithm, "kid": key.kid, **header}
    fields = {name: value for name, value in fields.items() if value is not None}
    registry = Registry(algorithms=[algorithm], strict_check_header=False)
    payload = claims if isinstance(claims, bytes) else orjson.dumps(claims)
    return jws.serialize_compact(fields, payload, key, [algorithm], registry)


class FakeProvider:
    """A provider with one signing key. Each attribute may be changed while it runs."""

    def __init__(self, issuer: str = ISSUER) -> None:
        self.issuer = issuer
        self.key: Key = rsa_key("first")
        self.published: list[Any] = [self.key.as_dict(private=False)]
        self.document: dict[str, Any] = {}  # changes of the discovery document
        self.claims: dict[str, Any] = {"sub": "4711", "preferred_username": "ada", "roles": ["ops"]}
        self.id_token: dict[str, Any] = {}  # changes of the claims of ID tokens; None removes one
        self.userinfo: dict[str, Any] = {"sub": "4711"}
        self.answers: dict[str, httpx2.Response] = {}  # by path, instead of the usual ones
        self.away = False
        self.asked: list[str] = []
        self.redeemed: list[dict[str, str]] = []
        self._codes: dict[str, dict[str, str]] = {}

    def discovery(self) -> dict[str, Any]:
        names = {"authorization_endpoint": "authorize", "token_endpoint": "token", "jwks_uri": "keys"}
        usual = {name: f"{self.issuer}/{path}" for name, path in names.items()}
        return {"issuer": self.issuer, **usual, **self.document}

    def authorize(self, address: str) -> dict[str, str]:
        """What a person's browser does at the provider; the query with which it is sent back."""
        asked = dict(parse_qsl(urlsplit(address).query))
        code = f"code-{len(self._codes)}"
        self._codes[code] = asked
        return {"code": code, "state": asked["state"]}

    def access_token(self, kind: str | None = None, **changes: Any) -> str:
        return sign(self.key, self._signed({"aud": AUDIENCE, **changes}), typ=kind)

    def _signed(self, changes: dict[str, Any]) -> dict[str, Any]:
        now = int(time.time())
        claims = {"iss": self.issuer, "iat": now, "exp": now + 300, **self.claims, **changes}
        return {name: value for name, value in claims.items() if value is not None}

    def answer(self, path: str, body: bytes) -> httpx2.Response:
        """The answer to a request."""
        self.asked.append(path)
        if path in self.answers:
            return self.answers[path]
        match path:
            case "/.well-known/openid-configuration":
                return httpx2.Response(200, json=self.discovery())
            case "/keys":
                return httpx2.Response(200, json={"keys": self.published})
            case "/userinfo":
                return httpx2.Response(200, json=self.userinfo)
            case "/token":
                return self._redeem({name: values[0] for name, values in parse_qs(body.decode()).items()})
        return httpx2.Response(404, json={})

    def _redeem(self, body: dict[str, str]) -> httpx2.Response:
        self.redeemed.append(body)
        asked = self._codes.pop(body.get("code", ""), None)
        digest = hashlib.sha256(body.get("code_verifier", "").encode()).digest()
        if (
            asked is None
            or asked["code_challenge"] != encode(digest)
            or asked["redirect_uri"] != body.get("redirect_uri")
            or asked["code_challenge_method"] != "S256"
        ):
            return httpx2.Response(400, json={"error": "invalid_grant"})
        claims = self._signed({"aud": asked["client_id"], "nonce": asked["nonce"], **self.id_token})
        return httpx2.Response(200, json={"id_token": sign(self.key, claims), "access_token": "opaque"})

    def client(self) -> httpx2.AsyncClient:
        """A client that reaches this provider without a network."""

        async def handle(request: httpx2.Request) -> httpx2.Response:
            if self.away:
                raise httpx2.ConnectError("connection refused")
            answer = self.answer(request.url.path, await request.aread())
            try:
                content = httpx2.ByteStream(answer.content)
            except httpx2.ResponseNotRead:
                return answer  # a stream already
            return httpx2.Response(answer.status_code, headers=answer.headers, stream=content)

        return httpx2.AsyncClient(transport=httpx2.MockTransport(handle))

    @contextmanager
    def served(self) -> Iterator[str]:
        """Serve it over HTTP on this machine; its issuer."""
        provider = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                length = int(self.headers.get("content-length", 0))
                if provider.away:
                    self.close_connection = True
                    return
                answer = provider.answer(urlsplit(self.path).path, self.rfile.read(length))
                content = answer.read()
                self.send_response(answer.status_code)
                self.send_header("Content-Length", str(len(content)))
                self.end_headers()
                self.wfile.write(content)

            do_POST = do_GET  # noqa: N815 - as the base class names it

            def log_message(self, *_: Any) -> None:
                pass

        with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
            thread = threading.Thread(target=server.serve_forever, daemon=True)
            thread.start()
            self.issuer = f"http://127.0.0.1:{server.server_port}"
            yield self.issuer
            server.shutdown()
            thread.join()


class Endless(httpx2.AsyncByteStream):
    """An answer without an end: quickly, or a byte now and then."""

    def __init__(self, part: bytes = b" " * 65_536, pause: float = 0.0) -> None:
        self._part, self._pause = part, pause

    async def __aiter__(self) -> AsyncIterator[bytes]:
        while True:
            await asyncio.sleep(self._pause)
            yield self._part


@contextmanager
def running_mock(*people: dict[str, Any]) -> Iterator[str]:
    """`oidc-provider-mock` in a process of its own, with these people; its issuer."""
    known = (part for person in people for part in ("--user-claims", orjson.dumps(person).decode()))
    command = (sys.executable, "-m", "oidc_provider_mock", "--port", "0", *known)
    with Process(*command, env=dict(os.environ)) as process:
        yield re.sub(r".*(http://[0-9.:]+).*", r"\1", process.wait_for("running on http")).strip()


def oidc_settings(issuer: str, **changes: str) -> dict[str, str]:
    """Settings of a gateway where people and services of a provider log in."""
    return {
        "oidc_issuer": issuer,
        "oidc_client_id": CLIENT,
        "oidc_client_secret": "a secret",
        "oidc_audience": AUDIENCE,
        "oidc_name": "Site login",
        "oidc_roles": "ops=operator,admins=admin",
        **changes,
    }
