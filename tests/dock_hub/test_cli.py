"""`dock-gateway hub key`, and what a start says about a file of keys."""

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from dock_gateway.cli import main
from dock_gateway.sites.identity import Signer, Verifier
from dock_gateway.sites.settings import find_broker_fault
from dock_hub.settings import HubSettings


def test_the_public_keys_of_a_hub(tmp_path: Path) -> None:
    private, public = tmp_path / "hub.key", tmp_path / "hub.json"
    first, second = (CliRunner().invoke(main, ["hub", "key", "--hub-private-key", str(private)]) for _ in range(2))
    assert first.exit_code == 0
    assert first.output == second.output
    assert Signer.load_or_create(private).public_keys()["keys"][0]["x"] in first.output
    public.write_text(first.output)
    Verifier(public, "berlin")


def test_a_hub_is_no_site(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DOCK_GATEWAY_SITE", "berlin")
    result = CliRunner().invoke(main, ["hub", "--nats", "nats://127.0.0.1"])
    assert result.exit_code == 2
    assert "a hub is not a site of another hub" in result.output


@pytest.mark.parametrize(
    ("setting", "sentence"),
    [
        ("nats_credentials", "nats_credentials: .* is no file of NATS credentials"),
        ("nats_ca", "nats_ca: .* is no PEM file with certificates"),
    ],
)
def test_a_start_with_other_files(tmp_path: Path, setting: str, sentence: str) -> None:
    (path := tmp_path / "file").write_text("something else\n")
    fault = find_broker_fault(HubSettings(**{setting: path}))  # type: ignore[arg-type]
    assert re.fullmatch(f"{sentence}.*", fault or "")
    option = f"--{setting.replace('_', '-')}"
    result = CliRunner().invoke(main, ["hub", "--nats", "nats://127.0.0.1", "--port", "0", option, str(path)])
    assert result.exit_code == 2
    assert setting in result.output


def test_a_file_that_is_no_key(tmp_path: Path) -> None:
    (path := tmp_path / "hub.key").write_text("secret")
    result = CliRunner().invoke(main, ["hub", "key", "--hub-private-key", str(path)])
    assert (result.exit_code, result.output) == (
        1,
        f"Error: {path} is not the hub's key, which is a private Ed25519 key as a JWK\n",
    )
