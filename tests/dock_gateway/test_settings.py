"""Settings: from the environment and options, checked, and every one documented."""

import re
import sys
from pathlib import Path
from typing import Annotated

import click
import pytest
from click.testing import CliRunner
from pydantic import ValidationError
from scripts import settings_table

from dock_gateway.cli import main
from dock_gateway.cli.options import (
    FIELDS,
    TYPE,
    arguments_of,
    groups_of,
    is_tuning,
    option_name,
    read_settings,
)
from dock_gateway.setting_types import ListensOn
from dock_gateway.settings import WITHOUT_OPTION, Settings, unknown_variables


@pytest.fixture(autouse=True)
def clean_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in TYPE.model_fields:
        monkeypatch.delenv(f"DOCK_GATEWAY_{name.upper()}", raising=False)


def test_every_setting_is_documented_as_it_is() -> None:
    assert settings_table.written() == settings_table.tables(), "run `make format`"
    assert [
        name for name in TYPE.model_fields if f"| `DOCK_GATEWAY_{name.upper()}` |" not in settings_table.written()
    ] == []


def test_the_environment_is_read_and_options_win(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DOCK_GATEWAY_PORT", "9000")
    monkeypatch.setenv("DOCK_GATEWAY_ALLOWED_ORIGINS", "https://a.example, https://b.example")
    assert Settings().port == 9000
    assert Settings().allowed_origins == ("https://a.example", "https://b.example")
    assert read_settings({"port": "9001", "host": None}).port == 9001


@pytest.mark.parametrize(
    ("written", "origin"),
    [
        ("http://10.0.0.5:3000/", "http://10.0.0.5:3000"),
        ("HTTPS://Ops.Example", "https://ops.example"),
        ("http://ops.example:80", "http://ops.example"),
        ("https://ops.example:443/", "https://ops.example"),
        ("https://ops.example:80", "https://ops.example:80"),
        ("http://[::1]:3000/", "http://[::1]:3000"),
        ("capacitor://localhost", "capacitor://localhost"),
        ("*", "*"),
        ("null", "null"),
    ],
)
def test_an_origin_is_compared_as_browsers_send_it(written: str, origin: str) -> None:
    assert read_settings({"allowed_origins": written}).allowed_origins == (origin,)


@pytest.mark.parametrize(
    ("written", "instead"),
    [
        ("192.168.1.20:9090", "write http://192.168.1.20:9090 or https://192.168.1.20:9090"),
        ("ops.example", "write http://ops.example or https://ops.example"),
        ("ws://robot:8000", "write http://robot:8000"),
        ("https://ops.example/ui/", "write https://ops.example"),
        ("https://*.ops.example", "write it like http://10.0.0.5:3000"),
        ("http://ada@ops.example", "write it like http://10.0.0.5:3000"),
    ],
)
def test_what_no_browser_sends_as_an_origin_is_refused_at_the_start(written: str, instead: str) -> None:
    with pytest.raises(click.UsageError, match=re.escape(f"{written!r} is not an origin")) as refused:
        read_settings({"allowed_origins": f"https://a.example,{written}"})
    assert refused.value.message.endswith(instead)


@pytest.mark.parametrize(
    ("written", "name"),
    [
        ("Robot.Local:8000", "robot.local"),
        ("http://robot.local:8000/ui/", "robot.local"),
        ("[fd00::5]", "fd00::5"),
        ("FD00::5", "fd00::5"),
    ],
)
def test_a_host_is_compared_without_its_port(written: str, name: str) -> None:
    assert read_settings({"allowed_hosts": written}).allowed_hosts == (name,)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("port", "70000"),
        ("port", "x"),
        ("allowed_hosts", "*.local"),
        ("lost_after", "-1"),
        ("log_level", "loud"),
        ("lost_after", "2"),
        ("memory_max_goals", "0"),
        ("ping_interval", "3"),
        ("node_name", "dock-gateway"),
        ("node_name", ""),
        ("node_name", "1st"),
        ("namespace", "/robot 1"),
        ("namespace", "/robot1//arm"),
        ("namespace", "/1st"),
        ("namespace", "//"),
        ("battery_topic", ""),
        ("battery_topic", "battery status"),
        ("cmd_vel_topic", "cmd_vel/"),
        ("stop_state_topic", "1stop"),
        ("emergency_stop_topics", "e_stop, /hall//e_stop"),
        ("diagnostics_topic", "~/diagnostics"),
        ("dock_action", "/dock/{name}"),
        ("undock_action", "undöck"),
        ("dock_action_type", "ConnectToChargingDock"),
        ("dock_action_type", "some_package/msg/Dock"),
        ("dock_action_type", "../action/Dock"),
        ("undock_action_type", "Undock"),
        ("trusted_proxies", "proxy.example"),
        ("trusted_proxies", "10.0.0.1/8"),
        ("trusted_proxies", "*"),
        ("tls_cert", "cert.pem"),
        ("tls_key", "key.pem"),
        ("tls_client_ca", "ca.pem"),
        ("feedback_retention_days", "1e12"),
        ("feedback_retention_days", "inf"),
        ("feedback_retention_mb", "1000000001"),
        ("goal_retention_days", "365001"),
        ("goal_retention_days", "nan"),
        ("goal_retention_mb", "1000000001"),
        ("audit_retention_days", "1e9"),
    ],
)
def test_wrong_settings_are_refused_by_name(name: str, value: str) -> None:
    with pytest.raises(click.UsageError, match=name):
        read_settings({name: value})


@pytest.mark.parametrize("namespace", ["", "/", "robot1", "/robot1", "/fleet/robot_2/", "_x"])
def test_namespaces(namespace: str) -> None:
    assert Settings(namespace=namespace).namespace == namespace


def test_what_is_wrong_is_said_in_a_plain_sentence() -> None:
    with pytest.raises(click.UsageError) as refused:
        read_settings({"namespace": "/robot 1"})
    assert (
        refused.value.message
        == "namespace: '/robot 1' is not a ROS namespace such as /robot1: letters, digits, _ and /"
    )


def test_settings_are_frozen() -> None:
    with pytest.raises(ValidationError):
        Settings().port = 1  # type: ignore[misc]


def test_host_names_are_read_in_lower_case() -> None:
    assert Settings(allowed_hosts="Robot.Local, b").allowed_hosts == ("robot.local", "b")  # type: ignore[arg-type]
    assert Settings(allowed_hosts=("Robot.Local",)).allowed_hosts == ("robot.local",)
    assert Settings(allowed_hosts="").allowed_hosts == ()  # type: ignore[arg-type]


def test_topics_are_read_as_they_are_written() -> None:
    """ROS tells apart names that differ only in case: an emergency stop must not be listened for elsewhere."""
    assert Settings(emergency_stop_topics="EStop, /hall/E_STOP, ").emergency_stop_topics == ("EStop", "/hall/E_STOP")  # type: ignore[arg-type]


def test_names_are_resolved_as_ros_does() -> None:
    assert Settings().resolve("connect_to_charging_dock") == "/connect_to_charging_dock"
    assert Settings(namespace="/robot1").resolve("dock") == "/robot1/dock"
    assert Settings(namespace="robot1/").resolve("/dock") == "/dock"
    assert Settings(namespace="/robot1").resolve("dock", "/robot2") == "/robot2/dock"
    assert Settings(namespace="/robot1").resolve("dock", "/") == "/dock"


def test_help_names_every_setting_but_those_for_tuning() -> None:
    text = CliRunner().invoke(main, ["serve", "--help"]).output
    tuning = {name for name, field in FIELDS if is_tuning(field)}
    assert {name for name, _ in FIELDS if not re.search(rf"{option_name(name)}\b(?!-)", text)} == {
        *WITHOUT_OPTION,
        *tuning,
    }
    assert "ping_interval" in tuning
    assert [heading for heading in groups_of(TYPE) if f"\n{heading}:\n" not in text] == []
    assert "](" not in text, "a terminal shows no Markdown links"


def test_a_switch_is_a_flag(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DOCK_GATEWAY_AUTHENTICATION", "true")
    assert arguments_of({"authentication": False, "store_poses": True, "host": None, "port": "1"}) == [
        "--no-authentication",
        "--store-poses",
        "--port=1",
    ]
    refused = CliRunner().invoke(main, ["serve", "--no-authentication", "--host", "192.0.2.1"])
    assert "--allow-open" in refused.output


def test_what_is_kept_of_one_robot_is_kept_apart_from_another(monkeypatch: pytest.MonkeyPatch) -> None:
    """`dock-gateway up` and `serve` on one machine: each meets other robots, both may be called `/`."""

    def names() -> tuple[str, ...]:
        settings = Settings()
        return settings.stop_file.name, Path(settings.database).name, settings.spool_folder.name

    for name in ("ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_DOMAIN_ID"):
        monkeypatch.delenv(name, raising=False)
    assert names() == ("stops-0.json", "history-0.db", "spool-0")
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    assert names() == ("stops-7.json", "history-7.db", "spool-7")
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    assert names() == ("stops-7-localhost.json", "history-7-localhost.db", "spool-7-localhost")
    chosen = Settings(stop_path=Path("/tmp/a"), spool_path=Path("/tmp/b"), database_url="sqlite:////tmp/c")
    assert (chosen.stop_file, chosen.spool_folder, chosen.database) == (
        Path("/tmp/a"),
        Path("/tmp/b"),
        "sqlite:////tmp/c",
    )


def test_trusted_proxies() -> None:
    assert Settings().trusted_proxies == ()
    assert Settings.model_validate({"trusted_proxies": "10.0.0.0/8, ::1"}).trusted_proxies == ("10.0.0.0/8", "::1")
    assert Settings.model_validate({"trusted_proxies": ""}).trusted_proxies == ()


def test_an_empty_path_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("CERT", "KEY", "CLIENT_CA"):
        monkeypatch.setenv(f"DOCK_GATEWAY_TLS_{name}", "")
    assert not Settings().tls


@pytest.mark.parametrize(
    ("options", "open_to"),
    [
        ({}, "machine"),
        ({"host": "0.0.0.0"}, "network"),
        ({"host": "192.0.2.1"}, "network"),
        ({"host": "0.0.0.0", "authentication": "true"}, None),
        ({"authentication": "true"}, None),
        # A container listens on all its addresses; what counts is where its port is published.
        ({"host": "0.0.0.0", "published_on": "127.0.0.1"}, "machine"),
        ({"host": "0.0.0.0", "published_on": "0.0.0.0"}, "network"),
        ({"host": "127.0.0.1", "published_on": "192.0.2.1"}, "network"),
    ],
)
def test_who_may_do_everything_without_a_login(options: dict[str, str], open_to: str | None) -> None:
    assert read_settings(dict(options)).open_to == open_to


def test_a_variable_that_is_no_setting_is_named_with_a_similar_one() -> None:
    known = ["PATH", "DOCK_GATEWAY_PORT", "dock_gateway_host", "DOCK_GATEWAY_TOKEN", "DOCK_GATEWAY_SERVICE_HOST"]
    assert unknown_variables(known, TYPE.model_fields) == []
    assert unknown_variables([*known, "DOCK_GATEWAY_BATERY_TOPIC", "DOCK_GATEWAY_X"], TYPE.model_fields) == [
        "DOCK_GATEWAY_BATERY_TOPIC is not a setting and has no effect. Did you mean DOCK_GATEWAY_BATTERY_TOPIC?",
        "DOCK_GATEWAY_X is not a setting and has no effect",
    ]


ROBOTS = """{
    "/robot1": {"dock_action": "/docking/dock", "undock_action": "undock", "battery": {"topic": "/power/battery"}},
    "/": {"battery": {"topic": "b", "percentage": "0-1"}},
    "/hall_a/*": {"default_dock": "a", "battery": {"percentage": "0-100"}},
    "/hall_a/robot2": {"default_dock": "b"},
    "*": {"default_dock": "c", "battery": {"charging_current": "negative"}}
}"""


def test_what_single_robots_have_of_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DOCK_GATEWAY_ROBOTS", ROBOTS)
    settings = Settings()
    assert settings.own_actions("dock") == {"/robot1": "/docking/dock"}
    assert settings.own_actions("undock") == {"/robot1": "/robot1/undock"}
    assert settings.battery_of("/robot1") == "/power/battery"
    assert settings.battery_of("/") == "/b"
    assert settings.battery_of("/robot2") == "/robot2/battery_status"
    names = ("/", "/robot1", "/hall_a/robot1", "/hall_a/robot2")
    assert [settings.default_dock_of(name) for name in names] == ["c", "c", "a", "b"]
    assert [settings.counts_to_100(name) for name in names] == [False, False, True, True]
    assert settings.charges_negative("/anything")
    assert Settings(default_dock="d").default_dock_of("/x") == "c"
    assert Settings(default_dock="d", robots={}).default_dock_of("/x") == "d"


@pytest.mark.parametrize(
    ("robots", "sentence"),
    [
        ("[", "write JSON such as"),
        ('{"/robot 1": {}}', "not one namespace such as /robot1"),
        ('{"/a": {}, "a/": {}}', "not one namespace"),
        ('{"/a/*": {"dock_action": "dock"}}', "stands for several robots"),
        ('{"*": {"battery": {"topic": "b"}}}', "stands for several robots"),
        ('{"/a": {"dock_action": "/dock"}, "/b": {"dock_action": "/dock"}}', "no two robots have the same"),
        ('{"/a": {"dock_actoin": "/dock"}}', "dock_actoin"),
        ('{"/a": {"battery": {"percentage": "100"}}}', "'0-1' or '0-100'"),
        ('{"/a": {"dock_action": "/dock/{x}"}}', "is not a ROS name"),
    ],
)
def test_wrong_tables_of_robots_are_refused(robots: str, sentence: str) -> None:
    with pytest.raises(click.UsageError, match="robots") as refused:
        read_settings({"robots": robots})
    assert sentence in refused.value.message


def test_the_ports_are_the_settings_that_say_so() -> None:
    assert (Settings().ports, Settings().own_ports) == ({"port": 8000}, {})

    class Further(Settings):
        pair_port: Annotated[int | None, ListensOn("/pair")] = None
        their_port: int = 22

    settings = Further(pair_port=9000)
    assert (settings.ports, settings.own_ports) == ({"port": 8000, "pair_port": 9000}, {9000: "/pair"})
    with pytest.raises(ValidationError, match="different ports"):
        Further(pair_port=8000)


def test_postgresql_without_its_driver(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "asyncpg", None)
    with pytest.raises(ValidationError, match=r"dock-gateway\[postgresql\] is not installed"):
        Settings(database_url="postgresql://db/history")
    assert Settings(database_url="memory:").database_url == "memory:"
