"""The output of programs: all of it in a file, what matters on the terminal."""

import subprocess
import sys
from pathlib import Path

import pytest

from dock_gateway.cli.output import ROS_FORMAT, Output, use_one_format

INFO = "[INFO] [2026-11-30 09:00:00.123] [dock_simulator]: Simulating a robot"
JSON = '{"time": "2026-11-30T09:00:00.123Z", "level": "info", "logger": "a", "message": "level: warning"}'
SHOWN = [
    "[WARN] [2026-11-30 09:00:00.123] [docking_server]: no battery",
    "[WARNING] [2026-11-30 09:00:00.123] [dock_gateway.stop]: [INFO] ",
    "[ERROR] [2026-11-30 09:00:00.123] [dock_gateway]: it broke",
    JSON.replace("info", "error"),
    "Traceback (most recent call last):",
    "Compiling the docking actions … 20 %",
]


@pytest.mark.parametrize("line", [INFO, INFO.replace("INFO", "DEBUG"), JSON, JSON.replace('"info"', '"debug"')])
def test_routine_lines_are_in_the_file_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str], line: str) -> None:
    with Output(tmp_path / "logs/up.log") as written:
        written.write(line)
    written.write("too late")
    assert (tmp_path / "logs/up.log").read_text() == f"{line}\n"
    assert capsys.readouterr() == ("", "")
    with Output(tmp_path / "up.log", verbose=True) as written:
        written.write(line)
    assert capsys.readouterr() == ("", f"{line}\n")


def test_all_others_are_on_the_terminal_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with Output(tmp_path / "up.log") as written:
        for line in SHOWN:
            written.write(line)
        written.note("the simulator ended (1)")
    assert capsys.readouterr().err.splitlines() == [*SHOWN, "dock-gateway: the simulator ended (1)"]
    *lines, last = (tmp_path / "up.log").read_text().splitlines()
    assert lines == SHOWN
    assert last.startswith("[WARN] [20")
    assert last.endswith("] [dock_gateway.cli.up]: the simulator ended (1)")


def test_full_files_are_renamed_and_the_oldest_goes(tmp_path: Path) -> None:
    with Output(tmp_path / "up.log", file_bytes=100) as written:
        for number in range(10):
            written.write(f"{INFO} {number}")
    names = ["up.log", "up.log.1", "up.log.2"]
    assert sorted(path.name for path in tmp_path.iterdir()) == names
    assert [(tmp_path / name).read_text()[-2] for name in names] == ["9", "8", "7"]


def test_a_log_that_cannot_be_written_is_said_once_and_nothing_is_lost(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").touch()
    for path in (tmp_path / "file/up.log", Path("/dev/full")):
        with Output(path) as written:
            written.write(INFO)
            written.write(INFO)
        said, *lines = capsys.readouterr().err.splitlines()
        assert said.startswith(f"dock-gateway: no log is written to {path}: ")
        assert lines == [INFO, INFO]


def test_lines_of_a_process_come_whole_whatever_their_bytes(tmp_path: Path) -> None:
    code = r"import os; os.write(1, b'a\xff\n'); os.write(2, b'b' * 100_000 + b'\nlast')"
    with (
        Output(tmp_path / "up.log") as written,
        subprocess.Popen(
            [sys.executable, "-c", code],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="utf-8",
            errors="backslashreplace",
        ) as process,
    ):
        written.follow(process).join()
    first, *rest, last = (tmp_path / "up.log").read_text().splitlines()
    assert (first, "".join(rest), last) == (r"a\xff", "b" * 100_000, "last")


def test_ros_writes_times_as_the_gateway_does_unless_the_user_has_a_format() -> None:
    environment: dict[str, str] = {}
    use_one_format(environment)
    assert environment == dict([ROS_FORMAT])
    use_one_format(own := {ROS_FORMAT[0]: "{message}"})
    assert own == {ROS_FORMAT[0]: "{message}"}
