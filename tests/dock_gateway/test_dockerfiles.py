"""The Dockerfiles: what can be checked without building them."""

import json
import re
import shlex
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
WHEELS, ON_ROS = "backend/Dockerfile", "backend/ros.Dockerfile"
KNOWN = {"ARG", "FROM", "RUN", "WORKDIR", "ENV", "COPY", "USER", "EXPOSE", "HEALTHCHECK", "ENTRYPOINT", "CMD"}
SENT = {line[1:] for line in ROOT.joinpath(".dockerignore").read_text().splitlines() if line.startswith("!")}


def instructions(name: str) -> list[tuple[str, str]]:
    """Name and arguments of each instruction, without comments and line breaks."""
    lines = [line for line in (ROOT / name).read_text().splitlines() if line and not line.startswith("#")]
    pairs = (line.split(maxsplit=1) for line in re.sub(r"\\\n\s*", "", "\n".join(lines)).splitlines())
    return [(instruction, arguments) for instruction, arguments in pairs]


def last_stage(name: str) -> dict[str, str]:
    found = instructions(name)
    start = max(index for index, (instruction, _) in enumerate(found) if instruction == "FROM")
    return dict(found[start:])


@pytest.mark.parametrize("name", [WHEELS, ON_ROS])
def test_each_instruction_is_one_and_copies_what_is_there(name: str) -> None:
    stages: list[str] = []
    for instruction, arguments in instructions(name):
        assert instruction in KNOWN
        words = shlex.split(arguments) if instruction != "HEALTHCHECK" else []
        if instruction == "FROM":
            assert words[0].startswith("${") or words[0] in stages or words[0] == "wheels-${WHEELS}"
            stages.append(words[2] if words[1:2] == ["AS"] else "last")
        elif instruction == "COPY" and words[0].startswith("--from="):
            assert words[0].removeprefix("--from=") in stages
        elif instruction == "COPY":
            for source in words[:-1]:
                assert source.partition("/")[0] in SENT, f".dockerignore leaves {source} out"
                assert source == "dist" or (ROOT / source).exists(), source
        elif instruction in {"CMD", "ENTRYPOINT"}:
            assert all(isinstance(word, str) for word in json.loads(arguments))
    assert stages[-1] == "last"


def test_both_images_behave_alike() -> None:
    wheels, on_ros = last_stage(WHEELS), last_stage(ON_ROS)
    for instruction in ("USER", "WORKDIR", "EXPOSE", "HEALTHCHECK", "CMD"):
        assert on_ros[instruction] == wheels[instruction]
    assert on_ros["USER"] == "dock"
    variables = set(shlex.split(wheels["ENV"]))
    assert variables - set(shlex.split(on_ros["ENV"])) == {"AMENT_PREFIX_PATH=/opt/dock-gateway"}
    assert json.loads(on_ros["ENTRYPOINT"])[2].endswith(' exec "$@"')
