"""Who asks: signed by the hub, verified by a site."""

from base64 import urlsafe_b64encode
from pathlib import Path
from typing import Any

import orjson
import pytest
from joserfc import jwt
from joserfc.jwk import OctKey, OKPKey

from dock_gateway.core.errors import GatewayError, TooManyRequests
from dock_gateway.core.grant import UNLIMITED, Grant, Role
from dock_gateway.sites import identity
from dock_gateway.sites.identity import AHEAD, KIND, LIFETIME, IdentityReused, KeyFault, Signer, Verifier, content_of

NOW = 1_800_000_000.25
GRANT = Grant(Role.OPERATOR, ("/robot1", "/hall_a/*"), ("*/dock",), ("/robot1/battery_status",))
REQUEST = ("0123456789abcdef", "POST", "/dock")


@pytest.fixture
def signer(tmp_path: Path) -> Signer:
    return Signer.load_or_create(tmp_path / "keys" / "hub.key")


@pytest.fixture
def verifier(signer: Signer, tmp_path: Path) -> Verifier:
    return trusting(signer, tmp_path)


def trusting(signer: Signer, folder: Path, site: str = "berlin") -> Verifier:
    keys = folder / "hub_keys.json"
    keys.write_bytes(orjson.dumps(signer.public_keys()))
    return Verifier(keys, site)


def signed(signer: Signer, name: str | None = "alice", grant: Grant = GRANT, now: float = NOW) -> str:
    instance, method, path = REQUEST
    return signer.sign("berlin", instance, name, grant, method, path, now)


def refusal(verifier: Verifier, token: str, *request: str, now: float = NOW) -> str:
    with pytest.raises(GatewayError) as refused:
        verifier.verify(token, *(request or REQUEST), now)
    assert refused.value.code == "invalid_identity"
    return refused.value.detail.removeprefix("who asks is not accepted: ")


@pytest.mark.parametrize(("name", "grant"), [("alice", GRANT), ("oidc:ädä", GRANT), (None, UNLIMITED)])
def test_what_the_hub_signs(signer: Signer, verifier: Verifier, name: str | None, grant: Grant) -> None:
    said = verifier.verify(signed(signer, name, grant), *REQUEST, NOW + 1)
    assert (said.name, said.grant, said.expires_at) == (name, grant, NOW + LIFETIME)
    assert said.key == signer.public_keys()["keys"][0]["kid"]


def test_one_request_only(signer: Signer, verifier: Verifier) -> None:
    token = signed(signer)
    assert refusal(verifier, token, "fedcba9876543210", *REQUEST[1:]).startswith("it is for another site")
    assert refusal(verifier, token, REQUEST[0], "DELETE", "/dock") == "it is for another request"
    assert refusal(verifier, token, *REQUEST[:2], "/undock") == "it is for another request"
    verifier.verify(token, *REQUEST, NOW)
    with pytest.raises(IdentityReused):
        verifier.verify(token, *REQUEST, NOW)
    assert refusal(verifier, token, now=NOW + LIFETIME) == "it has expired"


def test_what_is_refused_in_any_case_is_refused_before_its_signature(
    signer: Signer, verifier: Verifier, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A signature takes long to verify: neither a late message, nor one for others, nor a repeated one costs that."""
    stranger = Signer.load_or_create(tmp_path / "stranger.key")
    token = signed(signer)
    verifier.verify(token, *REQUEST, NOW)
    decoded: list[str] = []
    monkeypatch.setattr(identity.jwt, "decode", lambda token, *_: decoded.append(token))
    refusals = (
        refusal(verifier, signed(stranger, now=NOW - LIFETIME)),
        refusal(verifier, signed(stranger), "fedcba9876543210", *REQUEST[1:]),
        refusal(verifier, signed(stranger), REQUEST[0], "DELETE", "/dock"),
    )
    assert refusals[0] == "it has expired"
    with pytest.raises(IdentityReused):
        verifier.verify(token, *REQUEST, NOW)
    assert decoded == []


def test_a_query_and_a_body_that_were_changed_on_the_way(signer: Signer, verifier: Verifier) -> None:
    sent = content_of("robot=/r1", b'{"dock_id":"1"}')
    others = (("robot=/r2", b'{"dock_id":"1"}'), ("robot=/r1", b'{"dock_id":"2"}'), ("robot=/r1", None), ("", b""))
    assert sent not in {content_of(query, body) for query, body in others}
    token = signer.sign("berlin", *REQUEST[:1], "alice", GRANT, *REQUEST[1:], NOW, content=sent)
    for query, body in others:
        with pytest.raises(GatewayError, match="it is for another request"):
            verifier.verify(token, *REQUEST, NOW, content_of(query, body))
    verifier.verify(token, *REQUEST, NOW, sent)


def test_another_site(signer: Signer, tmp_path: Path) -> None:
    assert refusal(trusting(signer, tmp_path, "oslo"), signed(signer)).startswith("it is for another site")


def test_clocks(signer: Signer, verifier: Verifier) -> None:
    verifier.verify(signed(signer, now=NOW + AHEAD), *REQUEST, NOW)
    assert "not valid yet" in refusal(verifier, signed(signer, now=NOW + AHEAD + 1))
    assert refusal(verifier, signed(signer, now=NOW - LIFETIME)) == "it has expired"


def test_a_deadline(signer: Signer, verifier: Verifier) -> None:
    instance, method, path = REQUEST
    token = signer.sign("berlin", instance, "alice", GRANT, method, path, NOW, lifetime=5)
    assert refusal(verifier, token, now=NOW + 5) == "it has expired"
    verifier.verify(token, *REQUEST, NOW + 4)


def test_used_ones_are_forgotten_when_they_have_expired(
    signer: Signer, verifier: Verifier, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(identity, "MAX_USED", 2)
    for _ in range(2):
        verifier.verify(signed(signer), *REQUEST, NOW)
    with pytest.raises(TooManyRequests):
        verifier.verify(signed(signer), *REQUEST, NOW)
    verifier.verify(signed(signer, now=NOW + LIFETIME), *REQUEST, NOW + LIFETIME)


def test_forgeries(signer: Signer, verifier: Verifier, tmp_path: Path) -> None:
    head, body, signature = signed(signer).split(".")
    stranger = Signer.load_or_create(tmp_path / "stranger.key")
    for forged in (
        signed(stranger),
        f"{head}.{signed(signer, 'root').split('.')[1]}.{signature}",
        f"{head}.{body}.",
        ".".join(signed(signer).split(".")[:2]),
        "",
        "..",
        "ä.ö.ü",
        *unsigned(signer, body),
    ):
        assert refusal(verifier, forged) == "it is not signed with a key of the site's --hub-public-keys"
    assert refusal(verifier, "x" * 200_000) == "it is too long"


def unsigned(signer: Signer, body: str) -> list[str]:
    """Tokens with algorithms that are not signatures of the hub: none, and its public key as a shared secret."""
    public = signer.public_keys()["keys"][0]
    none = urlsafe_b64encode(b'{"alg":"none"}').decode().rstrip("=")
    secret = OctKey.import_key(public["x"].encode())
    return [f"{none}.{body}.", jwt.encode({"alg": "HS256", "typ": KIND, "kid": public["kid"]}, {}, secret, ["HS256"])]


@pytest.mark.parametrize(
    ("kind", "change", "reason"),
    [
        ("JWT", {}, "it was signed for another purpose"),
        (KIND, {"iss": "someone"}, "something is missing in it"),
        (KIND, {"role": "root"}, "something is missing in it"),
        (KIND, {"robots": [""]}, "something is missing in it"),
        (KIND, {"sub": "a\nb"}, "something is missing in it"),
        (KIND, {"exp": NOW + 3600}, "it is not valid yet, or for too long"),
    ],
)
def test_other_claims(tmp_path: Path, signer: Signer, kind: str, change: dict[str, Any], reason: str) -> None:
    key = OKPKey.import_key(orjson.loads((tmp_path / "keys" / "hub.key").read_bytes()))
    claims = jwt.decode(signed(signer), key, ["Ed25519"]).claims
    token = jwt.encode({"alg": "Ed25519", "typ": kind, "kid": key.thumbprint()}, {**claims, **change}, key, ["Ed25519"])
    assert refusal(trusting(signer, tmp_path), token) == reason


def test_the_key_is_kept_and_is_for_its_user_alone(tmp_path: Path, signer: Signer) -> None:
    path = tmp_path / "keys" / "hub.key"
    assert Signer.load_or_create(path).public_keys() == signer.public_keys()
    assert path.stat().st_mode & 0o777 == 0o600
    assert [each.name for each in path.parent.iterdir()] == ["hub.key"]
    assert "d" not in signer.public_keys()["keys"][0]


@pytest.mark.parametrize("text", ["", "{}", "[]", '{"keys": []}', '{"keys": [{"kty": "RSA"}]}', '{"keys": 5}'])
def test_files_that_are_no_keys(tmp_path: Path, text: str) -> None:
    path = tmp_path / "keys.json"
    path.write_text(text)
    with pytest.raises(KeyFault, match="not what `dock-gateway hub key` prints"):
        Verifier(path, "berlin")
    with pytest.raises(KeyFault, match="not the hub's key"):
        Signer.load_or_create(path)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(KeyFault, match="cannot be read: No such file"):
        Verifier(tmp_path / "none.json", "berlin")
    with pytest.raises(KeyFault, match="cannot be read or made"):
        Signer.load_or_create(tmp_path)
