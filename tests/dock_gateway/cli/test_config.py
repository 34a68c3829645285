"""The configuration file, and the commands that show and check settings."""

from pathlib import Path

import click
import orjson
import pytest
from click.testing import CliRunner, Result

from dock_gateway.cli import main
from dock_gateway.cli.options import TYPE, read_settings
from dock_gateway.setting_groups.one_robot import describe_table
from dock_gateway.settings import Settings
from tests.support.installed import needs

FILE = """
port = 9000
authentication = true
allow_publish = ["/battery_status", "/robot1/*"]
robots."/robot1".default_dock = "lab"
database_url = "postgresql://ada:secret@host/name"
"""


@pytest.fixture(autouse=True)
def file(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    for name in (*TYPE.model_fields, "config"):
        monkeypatch.delenv(f"DOCK_GATEWAY_{name.upper()}", raising=False)
    path = tmp_path / "gateway.toml"
    path.write_text(FILE)
    monkeypatch.setenv("DOCK_GATEWAY_CONFIG", str(path))
    return path


def run(*arguments: str) -> Result:
    return CliRunner().invoke(main, ["config", *arguments])


def test_an_option_comes_before_a_variable_and_that_before_the_file(monkeypatch: pytest.MonkeyPatch) -> None:
    assert (Settings().port, Settings().authentication) == (9000, True)
    assert read_settings({}).allow_publish == ("/battery_status", "/robot1/*")
    monkeypatch.setenv("DOCK_GATEWAY_PORT", "9001")
    assert read_settings({"port": None}).port == 9001
    assert read_settings({"port": "9002"}).port == 9002


def test_a_table_of_a_robot(file: Path) -> None:
    file.write_text("""
        [robots."/robot1"]
        dock_action = "/docking/dock_robot"
        battery = { topic = "/power/battery_status", percentage = "0-100", charging_current = "negative" }
        default_dock = "lab"
    """)
    settings = read_settings({})
    assert settings.own_actions("dock") == {"/robot1": "/docking/dock_robot"}
    assert settings.battery_of("/robot1") == "/power/battery_status"
    assert (settings.counts_to_100("/robot1"), settings.charges_negative("/robot1")) == (True, True)
    assert settings.default_dock_of("/robot1") == "lab"


def test_lines_of_advice_are_lines_of_the_file(file: Path) -> None:
    lines = describe_table("/robot1", dock_action="/a/dock", battery__percentage="0-100", undock_action=None)
    file.write_text("\n".join(lines))
    assert read_settings({}).own_actions("dock") == {"/robot1": "/a/dock"}
    assert read_settings({}).counts_to_100("/robot1")


@needs("recordings")
def test_settings_of_extensions_are_in_the_file_too(file: Path) -> None:
    file.write_text('recordings = "all"')
    assert getattr(read_settings({}), "recordings") == "all"  # noqa: B009 - of an extension


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("prot = 1", "prot is not a setting. Did you mean port?"),
        ("[oidc]\nissuer = 1", "oidc is not a setting"),
        ("port", "is not TOML"),
        ("port = 'x'", "port: "),
        ("extensions = ['x']", "only be set as a variable, DOCK_GATEWAY_EXTENSIONS"),
        (None, "cannot be read: No such file or directory"),
    ],
)
def test_a_file_that_is_wrong_is_refused(file: Path, text: str | None, sentence: str) -> None:
    file.unlink() if text is None else file.write_text(text)
    with pytest.raises(click.UsageError) as refused:
        read_settings({})
    assert sentence in refused.value.message
    checked = run("check")
    assert (checked.exit_code, sentence in checked.output) == (2, True)


def test_show_says_where_a_value_comes_from_and_hides_secrets(monkeypatch: pytest.MonkeyPatch, file: Path) -> None:
    monkeypatch.setenv("DOCK_GATEWAY_LOG_LEVEL", "debug")
    monkeypatch.setenv("DOCK_GATEWAY_HOST", "127.0.0.1")
    text = run("show", "--no-store-poses").output
    assert f"port = 9000  (file {file})" in text
    assert "log_level = debug  (variable DOCK_GATEWAY_LOG_LEVEL)" in text
    assert "store_poses = false  (option --store-poses)" in text
    assert "postgresql://ada:********@host/name" in text
    assert "secret@" not in text
    assert 'robots = {"/robot1":{"default_dock":"lab"}}' in text
    assert "max_robots" not in text
    everything = orjson.loads(run("show", "--all", "--json").output)
    assert everything["max_robots"] == {"value": 500, "source": "default"}
    assert everything.keys() == TYPE.model_fields.keys()


def test_check_finds_variables_that_are_no_settings(monkeypatch: pytest.MonkeyPatch, file: Path) -> None:
    assert "the settings are valid" in run("check").output
    file.write_text("host = '0.0.0.0'")
    assert "--allow-open" in run("check").output
    file.write_text("")
    monkeypatch.setenv("DOCK_GATEWAY_PROT", "1")
    checked = run("check")
    assert (checked.exit_code, "Did you mean DOCK_GATEWAY_PORT?" in checked.output) == (1, True)


def test_the_option_names_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = tmp_path / "other.toml"
    other.write_text("port = 9009")
    monkeypatch.chdir(tmp_path)
    assert "port = 9009" in run("show", "--config", "other.toml").output
