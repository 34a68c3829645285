"""What a site and its hub need, and what a start says about files that cannot be used."""

from pathlib import Path

import click
import orjson
import pytest

from dock_gateway.cli.options import read_settings
from dock_gateway.cli.start import check_start
from dock_gateway.extensions.sites.settings import SiteSettings
from dock_gateway.sites.identity import Signer

SITE = {"nats": "nats://127.0.0.1:4222", "site": "berlin", "hub_public_keys": "hub.json"}


def test_a_site_and_its_hub() -> None:
    settings = read_settings({**SITE, "nats": "tls://ada:secret@nats.example.com, nats://[::1]:4222"}).of(SiteSettings)
    assert settings.nats == ("tls://ada:secret@nats.example.com", "nats://[::1]:4222")
    assert (settings.hub_role, settings.hub_robots) == ("operator", ())


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("site", "berlin"),
        ("site", "Berlin"),
        ("site", "hub"),
        ("site", "b" * 41),
        ("nats", "nats://127.0.0.1"),
        ("nats", "http://127.0.0.1"),
        ("nats", "tls://nats.example.com:4222/x"),
        ("nats", "nats.example.com"),
        ("hub_public_keys", "hub.json"),
        ("hub_role", "root"),
        ("hub_robots", "/robot1"),
        ("hub_robots", "robot1"),
    ],
)
def test_wrong_settings_are_refused_by_name(name: str, value: str) -> None:
    with pytest.raises(click.UsageError, match=name):
        read_settings({name: value})


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"site": None}, "nats needs site, the name of this site"),
        ({"hub_public_keys": None}, "nats needs hub_public_keys: a file with what `dock-gateway hub key` prints"),
        ({"hub_role": "admin", "hub_robots": "/robot1"}, "hub_robots limits no admin"),
        ({"nats": None}, "site needs nats, the NATS servers"),
        ({"nats": "nats://ada:secret@nats.example.com"}, "nats names a NATS server on another machine without TLS"),
        ({"nats": "nats://ada:secret@nats.example.com:x"}, "like tls://nats.example.com:4222"),
    ],
)
def test_a_site_that_cannot_work(change: dict[str, str | None], sentence: str) -> None:
    with pytest.raises(click.UsageError) as refused:
        read_settings({**SITE, **change})
    assert sentence in refused.value.message
    assert "secret" not in refused.value.message


def test_a_start_with_the_keys_of_the_hub(tmp_path: Path) -> None:
    (path := tmp_path / "hub.json").write_bytes(orjson.dumps(Signer.load_or_create(tmp_path / "hub.key").public_keys()))
    assert SiteSettings(nats="nats://127.0.0.1", site="berlin", hub_public_keys=path).find_fault() is None  # type: ignore[arg-type]
    assert SiteSettings().find_fault() is None


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"nats_credentials": "x"}, "nats_credentials and nats_ca need nats"),
        ({"nats_ca": "x"}, "nats_credentials and nats_ca need nats"),
        (SITE | {"hub_public_keys": "not/there.json"}, "hub_public_keys: .* cannot be read: No such file"),
    ],
)
def test_a_start_without_the_keys_of_the_hub(options: dict[str, str], sentence: str) -> None:
    with pytest.raises(click.UsageError, match=sentence):
        check_start(read_settings(dict(options)), {})


def test_a_start_with_a_file_of_another_kind(tmp_path: Path) -> None:
    (path := tmp_path / "hub.json").write_bytes(orjson.dumps(Signer.load_or_create(tmp_path / "hub.key").public_keys()))
    (other := tmp_path / "file").write_text("something else\n")
    with pytest.raises(click.UsageError, match=r"nats_ca: .* is no PEM file with certificates"):
        check_start(read_settings(SITE | {"hub_public_keys": str(path), "nats_ca": str(other)}), {})
