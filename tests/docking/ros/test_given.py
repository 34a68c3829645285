"""What a command line gives to nodes, without the nodes."""

from pathlib import Path

import pytest
from rclpy.context import Context

from docking.ros.given import Section, given_to, read_arguments, suggest

FILE = """
/**:
  ros__parameters: {use_sim_time: true}
robot1:
  docking_server:
    ros__parameters: {controller: {k_phi: 1e0, beta: .5}, docks: [a, b], max_retries: 3, "x.y": 'on', z: on}
"""


def sections(*args: str) -> list[Section]:
    """What a command line gives."""
    context = Context()
    read_arguments(context, args)
    return [*given_to(context).sections]


def test_files_and_rules_are_read_in_their_order(tmp_path: Path) -> None:
    file = tmp_path / "robot.yaml"
    file.write_text(FILE)
    rules = ("-p", "max_retries:=2", "--param", "docker:a.b:=[1.5]", "-p", "c:=[")
    assert sections("x", "-p", "no:=1", "--ros-args", "--params-file", str(file), *rules, "--", "-p", "no:=1") == [
        Section(str(file), "/**", {"use_sim_time": True}),
        Section(
            str(file),
            "/robot1/docking_server",
            {
                "controller.k_phi": 1.0,
                "controller.beta": 0.5,
                "docks": ("a", "b"),
                "max_retries": 3,
                "x.y": "on",
                "z": True,
            },
        ),
        Section("", "/**", {"max_retries": 2}),
        Section("", "/docker", {"a.b": (1.5,)}),
        Section("", "/**", {"c": None}),
    ]
    assert sections() == sections("--ros-args") == []


@pytest.mark.parametrize(
    ("nodes", "name", "fits"),
    [
        ("/**", "/a/b", True),
        ("/**/b", "/b", True),
        ("/**/b", "/a/c/b", True),
        ("/*/b", "/a/b", True),
        ("/*/b", "/b", False),
        ("/*/b", "/a/c/b", False),
        ("/b", "/a/b", False),
        ("/b", "/bb", False),
        ("/a/b", "/a/b", True),
        ("/(", "/(", False),
    ],
)
def test_sections_are_for_nodes_as_in_rclpy(nodes: str, name: str, fits: bool) -> None:
    assert Section("", nodes, {}).is_for(name) is fits


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("max_retrys", ". Did you mean max_retries?"),
        ("near.docking_treshold", ". Did you mean near.docking_threshold?"),
        ("nera.docking_threshold", ". Did you mean near.docking_threshold?"),
        ("near.tolerance", ""),
        ("speed", ""),
    ],
)
def test_a_similar_name_is_suggested(name: str, hint: str) -> None:
    assert suggest(name, ["max_retries", "near.docking_threshold", "near.frame", "controller"]) == hint
