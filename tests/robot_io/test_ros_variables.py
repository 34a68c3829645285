"""Variables of ROS that keep a node from seeing what it should see."""

from pathlib import Path

import pytest

from robot_io.ros_variables import DISCOVERY_SERVER_HINT, check, sees_part_of_graph


@pytest.mark.parametrize(
    "variables",
    [
        {},
        {"ROS_DOMAIN_ID": "0"},
        {"ROS_DOMAIN_ID": "101", "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_LOCALHOST_ONLY": "1"},
        {"ROS_DISCOVERY_SERVER": ""},
        {"ROS_DISCOVERY_SERVER": "127.0.0.1:11811", "ROS_SUPER_CLIENT": "true"},
    ],
)
def test_what_works_is_not_told(variables: dict[str, str]) -> None:
    assert check(variables) == []


@pytest.mark.parametrize(
    ("variables", "told", "fatal"),
    [
        ({"ROS_DISCOVERY_SERVER": "127.0.0.1:11811"}, "ROS_SUPER_CLIENT=true", False),
        ({"ROS_DISCOVERY_SERVER": ";10.0.0.1", "ROS_SUPER_CLIENT": "false"}, "ROS_SUPER_CLIENT=true", False),
        ({"ROS_DOMAIN_ID": "seven"}, "no number from 0 to 232", True),
        ({"ROS_DOMAIN_ID": "233"}, "no number from 0 to 232", True),
        ({"ROS_DOMAIN_ID": "-1"}, "no number from 0 to 232", True),
        ({"ROS_DOMAIN_ID": "150"}, "ports that Linux also gives", False),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "localhost"}, "'localhost', which is none of", False),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}, "no node of others is found", False),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_LOCALHOST_ONLY": "1"}, "overrides", False),
        ({"FASTDDS_DEFAULT_PROFILES_FILE": "/no/such.xml"}, "/no/such.xml, which cannot be read", False),
        ({"ROS_SECURITY_ENABLE": "true"}, "ROS_SECURITY_KEYSTORE is unset", False),
        ({"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce"}, "ROS_SECURITY_KEYSTORE is unset", True),
    ],
)
def test_what_does_not_is_told(variables: dict[str, str], told: str, fatal: bool) -> None:
    (finding,) = check(variables)
    assert told in finding.sentence
    assert finding.fatal is fatal
    assert any(name in finding.sentence for name in variables)


def test_a_profile_that_is_no_xml_is_told(tmp_path: Path) -> None:
    profile = tmp_path / "profile.xml"
    profile.write_text("<profiles>")
    (finding,) = check({"FASTRTPS_DEFAULT_PROFILES_FILE": str(profile)})
    assert str(profile) in finding.sentence
    profile.write_text("<profiles/>")
    assert check({"FASTRTPS_DEFAULT_PROFILES_FILE": str(profile)}) == []


def test_a_client_of_a_discovery_server_sees_part_of_the_graph() -> None:
    assert sees_part_of_graph({"ROS_DISCOVERY_SERVER": "127.0.0.1:11811"})
    assert "ROS_SUPER_CLIENT=true" in DISCOVERY_SERVER_HINT
