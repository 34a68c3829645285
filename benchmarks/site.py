"""A ROS domain with an action server in it, where one system is measured and no other is heard."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.support.domain import ros_domain
from tests.support.processes import Process

ROOT = Path(__file__).parent.parent
PRODUCT = ROOT / ".venv"
ACTION = "connect_to_charging_dock"
ACTION_TYPE = "action_tutorials_interfaces/action/ConnectToChargingDock"
LEAKING = (
    *("VIRTUAL_ENV", "PYTHONPATH", "PYTHONHOME", "LD_LIBRARY_PATH", "_ROS_WHEELS_BOOTSTRAP_COMPLETE"),
    "PYTHONDONTWRITEBYTECODE",  # a system that compiles itself at each start would start slowly
)


@dataclass(frozen=True)
class Goal:
    """A goal for the benchmark's action server: so many feedback messages at a rate, after a delay."""

    rate: float = 0.0
    count: int = 0
    delay: float = 0.0

    @property
    def state(self) -> dict[str, float]:
        """The BatteryState that says so."""
        return {"voltage": float(self.rate), "capacity": float(self.count), "charge": float(self.delay)}

    @property
    def seconds(self) -> float:
        """How long feedback is published."""
        return self.count / self.rate if self.rate else 0.0


@dataclass(frozen=True)
class Site:
    """Where a system is started."""

    domain: int
    payload: int
    server: Process

    def environment(self, prefix: Path = PRODUCT, **more: str) -> dict[str, str]:
        """The environment of a ROS program out of one Python environment, for this domain alone."""
        return {
            **{name: value for name, value in os.environ.items() if name not in LEAKING},
            **ros_variables(self.domain, prefix),
            **more,
        }


def ros_variables(domain: int, prefix: Path) -> dict[str, str]:
    """What makes a process meet only those on its domain, on this machine."""
    return {
        "PATH": f"{prefix / 'bin'}{os.pathsep}{os.environ['PATH']}",
        "AMENT_PREFIX_PATH": str(prefix),
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "PYTHONUNBUFFERED": "1",
    }


@contextmanager
def site(payload: int = 0, robots: int = 0) -> Iterator[Site]:
    """A domain of its own and the benchmark's action server on it."""
    with ros_domain() as domain:
        environment = {name: value for name, value in os.environ.items() if name not in LEAKING}
        environment |= ros_variables(domain, PRODUCT)
        command = [str(PRODUCT / "bin/python"), str(ROOT / "benchmarks/nodes/server.py"), "--ros-args"]
        command += ["-p", f"payload:={payload}", "-p", f"robots:={robots}"]
        with Process(*command, env=environment, cwd=ROOT) as server:
            server.wait_for("serving", 60)
            yield Site(domain, payload, server)


def site_packages(prefix: Path) -> Path:
    """Where an environment, of the Python that runs this, keeps its packages."""
    return prefix / f"lib/python{sys.version_info.major}.{sys.version_info.minor}/site-packages"
