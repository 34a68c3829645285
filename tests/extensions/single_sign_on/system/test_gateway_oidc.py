"""Logins with an identity provider at real gateways: people as a browser does it, and services with access tokens."""

import time
from pathlib import Path
from typing import Any

import httpx2
import orjson
import pytest

from tests.extensions.single_sign_on.provider import FakeProvider, oidc_settings, rsa_key, running_mock
from tests.support.access import Site, bearer, ends_with, log_in, stream
from tests.support.gateway import RunningGateway
from tests.support.installed import needs
from tests.support.waiting import wait_until

pytestmark = [needs("audit_log"), pytest.mark.ros]

ADA = {"sub": "4711", "preferred_username": "ada", "roles": ["ops"]}
EVE = {"sub": "4712", "preferred_username": "eve", "roles": ["guests"]}
COOKIE, LOGIN = "dock-gateway", "dock-gateway-login"


@pytest.fixture
def site(tmp_path: Path) -> Site:
    site = Site(tmp_path)
    site.user("root", "admin")
    return site


def begin(browser: httpx2.Client, gateway: RunningGateway, page: str = "/ui/goals") -> str:
    """Where the browser is sent."""
    answer = browser.get(f"{gateway.url}/session/oidc", params={"page": page})
    assert answer.status_code == 303, answer.text
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=lax" in cookie
    return str(answer.headers["location"])


def authorize(address: str, subject: str) -> str:
    """Log in at the provider; where it sends the browser then."""
    answer = httpx2.post(address, data={"sub": subject})
    assert answer.status_code == 302, answer.text
    return str(answer.headers["location"])


def sign_in(browser: httpx2.Client, gateway: RunningGateway, subject: str = "4711") -> httpx2.Response:
    return browser.get(authorize(begin(browser, gateway), subject))


def audited(gateway: RunningGateway, root: str, what: str) -> list[dict[str, Any]]:
    answer = gateway.http.get("/audit", params={"what": what}, headers=bearer(root))
    entries: list[dict[str, Any]] = answer.raise_for_status().json()["records"]
    return entries


def test_people_of_a_provider(shared_domain: int, site: Site) -> None:
    """In at one gateway, known at another and after a restart, out by an admin; recorded, as are refusals."""
    with running_mock(ADA, EVE) as issuer, httpx2.Client() as browser:
        settings = oidc_settings(issuer)
        with site.gateway(shared_domain, **settings) as one, site.gateway(shared_domain, **settings) as other:
            root = log_in(one, "root")
            wait_until(lambda: browser.get(f"{one.url}/session").json()["provider"]["logout_url"], "the provider")
            answer = sign_in(browser, one)
            assert (answer.status_code, answer.headers["location"]) == (303, "/ui/goals")
            secret = str(browser.cookies[COOKIE])
            assert LOGIN not in browser.cookies
            who = browser.get(f"{one.url}/session").json()["principal"]
            assert (who["name"], who["kind"], who["role"]) == ("oidc:ada", "person", "operator")
            (record,) = audited(one, root, "finish_login")
            assert (record["principal"], record["subject"]) == ("oidc:ada", "oidc:ada (4711)")
            assert "code=" not in repr(audited(one, root, "finish_login"))

            replayed = httpx2.get(str(answer.url), cookies={LOGIN: "x"})
            assert replayed.json()["code"] == "login_failed"
            with httpx2.Client(headers={"Accept": "text/html"}) as eve:
                refused = sign_in(eve, one, "4712")
            assert (refused.status_code, refused.headers["location"]) == (303, "/ui/goals?login_error=role_required")
            newest = wait_until(
                lambda: next(
                    (row for row in audited(one, root, "finish_login") if row["code"] == "role_required"), None
                ),
                "the record of the refusal",
            )
            assert (newest["outcome"], newest["subject"], newest["principal"]) == ("refused", "oidc:eve (4712)", None)
            evil = browser.get(f"{one.url}/session/oidc", params={"page": "//evil.example"})
            assert evil.json()["code"] == "invalid_field"

            wait_until(lambda: other.http.get("/robots", headers=bearer(secret)).is_success, "the session")
        with site.gateway(shared_domain, **settings) as one:
            with stream(one, "/ws/feedback", secret) as socket:
                people = one.http.get("/people", headers=bearer(root)).json()["people"]
                assert [(each["name"], each["subject"], each["sessions"]) for each in people] == [
                    ("oidc:ada", "4711", 1)
                ]
                ended = one.http.delete("/people/oidc%3Aada/sessions", headers=bearer(root))
                assert ended.status_code == 204
                assert ends_with(socket) == (4401, "invalid_token")
            assert one.http.get("/robots", headers=bearer(secret)).json()["code"] == "invalid_token"


def test_services_of_a_provider(shared_domain: int, site: Site) -> None:
    """An access token opens streams until it expires; keys are rotated; a provider that is down keeps nobody out."""
    provider = FakeProvider()
    with provider.served() as issuer, site.gateway(shared_domain, **oidc_settings(issuer)) as gateway:
        http = gateway.http

        def code(token: str) -> str | None:
            answer = http.get("/robots", headers=bearer(token))
            return None if answer.status_code == 200 else str(answer.json()["code"])

        token = provider.access_token(sub="fleet-manager", preferred_username=None)
        assert code(token) is None
        assert code(provider.access_token(aud="dashboard")) == "invalid_token"
        assert code(provider.access_token(roles=["guests"])) == "role_required"
        answer = http.post("/tokens", json={"name": "x", "role": "admin"}, headers=bearer(token))
        assert answer.json()["code"] == "role_required"

        expires = int(time.time()) + 6
        with stream(gateway, "/ws/feedback", provider.access_token(exp=expires)) as socket:
            assert orjson.loads(socket.recv())
            assert ends_with(socket) == (4401, "invalid_token")
            assert expires <= time.time() < expires + 5 + 5  # on a busy machine

        provider.key = rsa_key("second")
        provider.published.append(provider.key.as_dict(private=False))
        rotated = provider.access_token()
        wait_until(lambda: code(rotated) is None, "the new key")

        provider.away = True
        assert code(token) is None
        with httpx2.Client(base_url=gateway.url) as browser:
            away = wait_until(
                lambda: (answer := browser.get("/session/oidc")).status_code == 503 and answer, "that it is noticed"
            )
            assert (away.json()["code"], away.headers["retry-after"]) == ("provider_unavailable", "5")
            page = browser.get("/session/oidc", params={"page": "/ui/goals?a=b"}, headers={"Accept": "text/html"})
            assert page.headers["location"] == "/ui/goals?a=b&login_error=provider_unavailable"


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ({"oidc_roles": ""}, "needs oidc_roles"),
        ({"oidc_client_id": "", "oidc_client_secret": "", "oidc_audience": ""}, "needs oidc_client_id"),
        ({"oidc_audience": "dashboard"}, "must not be oidc_client_id"),
        ({"oidc_issuer": ""}, "needs oidc_issuer"),
        ({"authentication": "false"}, "needs authentication"),
    ],
)
def test_half_a_configuration_does_not_start(site: Site, setting: dict[str, str], said: str) -> None:
    settings = {"authentication": "true", **oidc_settings("https://login.example"), **setting}
    refused = site.run("serve", **{f"DOCK_GATEWAY_{name.upper()}": value for name, value in settings.items()})
    assert refused.returncode == 2
    assert said in refused.output
    assert "a secret" not in refused.output
