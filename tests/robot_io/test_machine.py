"""Nothing in the Python code depends on the processor; where ROS wheels are needed, `scripts/preflight` says so."""

import ctypes
import re
import subprocess
import sys
from pathlib import Path

import pytest

from robot_io import rclpy_private

ROOT = Path(rclpy_private.__file__).parents[2]
SCRIPTS = [path for path in (ROOT / "scripts").iterdir() if path.is_file() and path.name != "preflight"]
SOURCES = sorted([ROOT / "Makefile", *SCRIPTS, *(ROOT / "backend").rglob("*.py")])
# Names of processors, and what asks for them.
PROCESSOR = re.compile(r"x86_64|amd64|aarch64|arm64|armv7|platform\.machine|os\.uname|sys\.maxsize")
# Numbers of machine size, or bytes in the order of the machine.
NATIVE = re.compile(r"""struct\.(?:un)?pack(?:_from)?\(f?["'][^<>!={]|Struct\(f?["'][^<>!={]|\bsys\.byteorder\b""")
# Types that have the same size on every 64-bit Linux, and those that are as large as a pointer.
ALIKE = {
    ctypes.c_bool, ctypes.c_char_p, ctypes.c_int64, ctypes.c_size_t, ctypes.c_uint8, ctypes.c_uint64, ctypes.c_void_p,
}  # fmt: skip
STRUCTURES = [value for value in vars(rclpy_private).values() if isinstance(value, type(ctypes.Structure))]


@pytest.mark.parametrize("expression", [PROCESSOR, NATIVE], ids=["processor", "native"])
def test_no_source_names_a_processor_or_relies_on_one(expression: re.Pattern[str]) -> None:
    assert [str(path) for path in SOURCES if expression.search(path.read_text())] == []


@pytest.mark.parametrize("structure", STRUCTURES, ids=lambda structure: structure.__name__)
def test_sizes_and_alignments_are_those_of_the_compiler(structure: type[ctypes.Structure]) -> None:
    assert not {"_pack_", "_align_", "_layout_"} & vars(structure).keys()
    end = 0
    for name, kind, *bits in structure._fields_:
        item = getattr(kind, "_type_", kind) if issubclass(kind, ctypes.Array) else kind
        assert not bits
        assert item in ALIKE or item in STRUCTURES
        alignment = ctypes.alignment(kind)
        assert getattr(structure, name).offset == (end + alignment - 1) // alignment * alignment
        end = getattr(structure, name).offset + ctypes.sizeof(kind)


def preflight(folder: Path, *arguments: str, **environment: str) -> str:
    """Run it on a machine whose processor is aarch64. Return its sentence, which is empty if it accepts that."""
    uname = folder / "uname"
    uname.write_text('#!/bin/sh\n[ "$1" = -m ] && echo aarch64 || echo Linux\n')
    uname.chmod(0o755)
    run = subprocess.run(
        [ROOT / "scripts/preflight", *arguments],
        env={"PATH": f"{folder}:/usr/bin:/bin", **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert bool(run.returncode) == bool(run.stderr)
    return run.stderr


def test_aarch64_with_a_sourced_ros_alone(tmp_path: Path) -> None:
    assert "source a ROS installation and run scripts/setup-sourced" in preflight(tmp_path)
    assert "No ROS installation is sourced" in preflight(tmp_path, "--sourced", sys.executable)
    assert preflight(tmp_path, "--sourced", sys.executable, ROS_DISTRO="jazzy") == ""
    old = tmp_path / "python"
    old.write_text("#!/bin/sh\nexit 1\n")
    old.chmod(0o755)
    assert "Python 3.11 or newer is needed" in preflight(tmp_path, "--sourced", str(old), ROS_DISTRO="humble")
