"""The ROS package as colcon builds it.

Its code is `docking` and `robot_io`, links to the folders next to this one. Without a ROS installation, use the wheel:
/pyproject.toml.
"""

from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = "action_tutorials_py"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Action servers that dock and undock a robot, their clients, a simulated robot, the Fibonacci tutorial",
    maintainer="dock-gateway maintainers",
    maintainer_email="maintainers@dock-gateway.example",
    license="Apache-2.0",
    python_requires=">=3.11",
    install_requires=["setuptools"],
    packages=find_packages(include=["docking", "docking.*", "robot_io"]),
    package_data={"docking": ["py.typed"], "robot_io": ["py.typed"]},
    zip_safe=True,
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/config", [str(file) for file in Path("config").iterdir()]),
        (f"share/{PACKAGE}/launch", [str(file) for file in Path("launch").iterdir()]),
    ],
    entry_points={
        "console_scripts": [
            "connect_to_charging_dock_server = docking.programs:main",
            "connect_to_charging_dock_client = docking.programs:main",
            "disconnect_from_charging_dock_client = docking.programs:main",
            "docking_server = docking.programs:main",
            "dock_simulator = docking.programs:main",
            "docking_replay = docking.programs:main",
            "fibonacci_action_server = docking.programs:main",
            "fibonacci_action_client = docking.programs:main",
        ],
    },
)
