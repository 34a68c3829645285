"""`dock-gateway hub-key`, and what a start says about a file of keys."""

from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from dock_gateway.cli import main
from dock_gateway.cli.options import read_settings
from dock_gateway.cli.start import check_broker, check_hub
from dock_gateway.settings import Settings
from dock_gateway.sites.identity import Signer


def test_the_public_keys_of_a_hub(tmp_path: Path) -> None:
    private, public = tmp_path / "hub.key", tmp_path / "hub.json"
    first, second = (CliRunner().invoke(main, ["hub-key", "--hub-key-path", str(private)]) for _ in range(2))
    assert first.exit_code == 0
    assert first.output == second.output
    public.write_text(first.output)
    assert Signer.load_or_create(private).public_keys()["keys"][0]["x"] in first.output
    check_hub(Settings(hub="nats://127.0.0.1", site="berlin", hub_key=public))


def test_a_start_without_the_keys_of_the_hub(tmp_path: Path) -> None:
    check_hub(Settings())
    for name in ("nats_credentials", "nats_ca"):
        with pytest.raises(click.UsageError, match="need hub"):
            check_hub(Settings(**{name: tmp_path}))  # type: ignore[arg-type]
    with pytest.raises(click.UsageError, match=r"hub_key: .* cannot be read: No such file"):
        check_hub(Settings(hub="nats://127.0.0.1", site="berlin", hub_key=tmp_path / "hub.json"))


@pytest.mark.parametrize(
    ("setting", "sentence"),
    [
        ("nats_credentials", "nats_credentials: .* is no file of NATS credentials"),
        ("nats_ca", "nats_ca: .* is no PEM file with certificates"),
    ],
)
def test_a_start_with_other_files(tmp_path: Path, setting: str, sentence: str) -> None:
    (path := tmp_path / "file").write_text("something else\n")
    with pytest.raises(click.UsageError, match=sentence):
        check_broker(read_settings({setting: str(path)}))
    option = f"--{setting.replace('_', '-')}"
    result = CliRunner().invoke(main, ["hub", "--nats", "nats://127.0.0.1", "--port", "0", option, str(path)])
    assert result.exit_code == 2
    assert setting in result.output


def test_a_file_that_is_no_key(tmp_path: Path) -> None:
    (path := tmp_path / "hub.key").write_text("secret")
    result = CliRunner().invoke(main, ["hub-key", "--hub-key-path", str(path)])
    assert (result.exit_code, result.output) == (
        1,
        f"Error: {path} is not the hub's key, which is a private Ed25519 key as a JWK\n",
    )
