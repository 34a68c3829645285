"""Docks and undocks a simulated robot with the programs of a built colcon workspace: prove_workspace.py WORKSPACE.

Run by `scripts/colcon-workspace`, in an environment that has neither the gateway nor the web packages it needs.
"""

import os
import subprocess
import sys
from contextlib import ExitStack
from importlib.metadata import distribution
from importlib.util import find_spec
from pathlib import Path

from ament_index_python.packages import get_package_prefix, get_package_share_directory
from scripts.prove_interfaces import expect
from tests.support.domain import ros_domain

PACKAGE = "action_tutorials_py"


def prove_files(install: Path) -> None:
    """Everything comes from the workspace, and lies where the ROS tools look for it."""
    for package in (PACKAGE, "action_tutorials_interfaces"):
        expect(Path(get_package_prefix(package)) == install / package, f"ament index: {package}")
    for module in ("docking", "action_tutorials_interfaces"):
        spec = find_spec(module)
        expect(spec is not None and str(spec.origin).startswith(str(install.parent)), f"{module} is the workspace's")
    expect(find_spec("dock_gateway") is None, "no gateway")
    programs = {entry.name for entry in distribution(PACKAGE).entry_points}
    executables = {file.name for file in (install / PACKAGE / "lib" / PACKAGE).iterdir() if os.access(file, os.X_OK)}
    expect(executables == programs, f"programs: {', '.join(sorted(programs))}")
    source = Path("backend", PACKAGE)
    for file in ("package.xml", *sorted(str(path.relative_to(source)) for path in source.glob("*/*.yaml"))):
        expect((Path(get_package_share_directory(PACKAGE)) / file).is_file(), f"share/{PACKAGE}/{file}")


def prove_docking(install: Path) -> None:
    """With the parameter files that are installed, a simulated robot docks and undocks."""
    prefix = install / PACKAGE

    def command(program: str, *arguments: str) -> list[str]:
        return [str(prefix / "lib" / PACKAGE / program), *arguments]

    with ros_domain() as domain, ExitStack() as stack:
        environment = os.environ | {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        for program in ("dock_simulator", "docking_server"):
            parameters = prefix / "share" / PACKAGE / "config" / f"{program}.yaml"
            node = command(program, "--ros-args", "--params-file", str(parameters))
            process = stack.enter_context(subprocess.Popen(node, env=environment, stdout=subprocess.DEVNULL))
            stack.callback(process.terminate)
        for program in ("connect_to_charging_dock_client", "disconnect_from_charging_dock_client"):
            client = subprocess.run(
                command(program, "--timeout", "60"),
                env=environment,
                timeout=300,
                check=False,
                capture_output=True,
                text=True,
            )
            if client.returncode:
                sys.stdout.write(client.stdout[-2000:] + client.stderr[-2000:])
            expect(client.returncode == 0, f"{program} succeeds")


if __name__ == "__main__":
    prove_files(Path(sys.argv[1]).resolve() / "install")
    prove_docking(Path(sys.argv[1]).resolve() / "install")
