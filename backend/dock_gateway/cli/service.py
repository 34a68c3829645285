"""`dock-gateway service install`: writes the systemd unit of a gateway."""

import os
import pwd
import shutil
import sys
from collections.abc import Mapping
from pathlib import Path

import click
import platformdirs

from dock_gateway.cli.groups import CommandGroup
from dock_gateway.cli.serve import ROS_PREFIXES
from dock_gateway.cli.service_unit import find_unreadable, paths, system_unit, user_unit
from dock_gateway.cli.start import check_ros
from dock_gateway.setting_groups.group import PREFIX
from robot_io.installation import SOURCED, find_installation

UNIT = "dock-gateway.service"
SETTINGS = """\
# Settings of the service dock-gateway, one NAME=value a line; docs/configuration.md lists them. For example:
#
#   DOCK_GATEWAY_PORT=9000
#   DOCK_GATEWAY_DATABASE_URL=postgresql://user:password@host/name
#   ROS_DOMAIN_ID=7
#   DOCK_GATEWAY_CONFIG=/etc/dock-gateway/gateway.toml
"""


@click.group(cls=CommandGroup)
def service() -> None:
    """Run the gateway as a service of systemd."""


@service.command()
@click.option("--user", "for_user", is_flag=True, help="A service of your own user instead of the machine.")
@click.option(
    "--user-name",
    metavar="NAME",
    help="The existing user that it runs as. Without it: one that exists only while it runs.",
)
@click.option("--print", "only_print", is_flag=True, help="Show the unit, and write nothing.")
def install(for_user: bool, user_name: str | None, only_print: bool) -> None:
    """Write a systemd unit that runs `dock-gateway serve` of this environment.

    The unit has the ROS variables of this shell, and of ROS what is sourced here. Settings are in a file of their own,
    which is only written if there is none.
    """
    if for_user and user_name:
        raise click.UsageError("--user is a service of your own user: --user-name does not go with it")
    check_ros(os.environ)
    program = _program()
    variables = service_variables(os.environ)
    if for_user:
        folder, unit = platformdirs.user_config_path(), user_unit(program, variables)
        target = folder / "systemd/user" / UNIT
    else:
        _check_user(user_name, program, variables)
        folder, unit = Path("/etc"), system_unit(program, user_name, variables)
        target = folder / "systemd/system" / UNIT
    if only_print:
        click.echo(unit, nl=False)
        return
    settings = folder / "dock-gateway/settings.env"
    try:
        _write(target, unit, settings)
    except OSError as error:
        aim = " " if user_name is None else f" --user-name {user_name} "
        raise click.ClickException(
            f"cannot write {error.filename or target}: {error.strerror}; run "
            f"`{program} service install{aim}--print | sudo tee {target}`, or take --user"
        ) from None
    click.echo(f"Wrote {target}.\n\nNext:\n{_advice(for_user, settings)}")
    for hint in _hints(os.environ, settings, own_user=not for_user):
        click.echo(f"\n{hint}.")


def service_variables(environment: Mapping[str, str]) -> dict[str, str]:
    """Return the variables by which the service finds the same ROS and the same robots as this shell."""
    found = {name: value for name, value in sorted(environment.items()) if name.startswith(ROS_PREFIXES)}
    found.pop("ROS_LOG_DIR", None)  # a folder of who calls this
    installation = find_installation(environment)
    wheels = installation is not None and installation.wheels
    if environment.get("AMENT_PREFIX_PATH"):
        # With wheels, each start finds their libraries by itself.
        names = [name for name in SOURCED if not (wheels and name == "LD_LIBRARY_PATH")]
        found |= {name: environment[name] for name in names if environment.get(name)}
    elif wheels:
        found["AMENT_PREFIX_PATH"] = sys.prefix
    return found


def _program() -> Path:
    name = "dock-gateway"
    found = shutil.which(name, path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}")
    if found is None:
        raise click.ClickException(f"the command {name} is not in {Path(sys.executable).parent}: install it there")
    return Path(found).absolute()


def _check_user(name: str | None, program: Path, variables: Mapping[str, str]) -> None:
    """Refuse a user who does not exist or cannot read the environment.

    Raises:
        click.ClickException: The message says what to do.
    """
    if name is not None:
        try:
            pwd.getpwnam(name)
        except KeyError:
            raise click.ClickException(
                f"there is no user {name}: run `sudo useradd --system --shell /usr/sbin/nologin {name}`, or leave "
                "--user-name out"
            ) from None
    if (folder := find_unreadable(paths(program, variables), name)) is not None:
        raise click.ClickException(
            f"{folder} is closed to the user of the service: install dock-gateway in a folder such as "
            "/opt/dock-gateway, or take --user, or --user-name with the owner of that folder"
        )


def _write(target: Path, unit: str, settings: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(unit)
    target.chmod(0o644)
    settings.parent.mkdir(parents=True, exist_ok=True)
    if not settings.exists():
        settings.touch(mode=0o600)  # it may hold passwords
        settings.write_text(SETTINGS)


def _advice(for_user: bool, settings: Path) -> str:
    systemctl, journalctl = ("systemctl --user", "journalctl --user") if for_user else ("systemctl", "journalctl")
    steps = [
        (f"${{EDITOR:-nano}} {settings}", "the settings; the defaults do for a start"),
        (f"{systemctl} daemon-reload", ""),
        (f"{systemctl} enable --now dock-gateway", ""),
        *([("loginctl enable-linger", "keeps it running when you log out")] if for_user else []),
        (f"{journalctl} -u dock-gateway -f", "what it logs"),
    ]
    width = max(len(command) for command, why in steps if why)
    return "\n".join(f"  {command:{width}}  {'# ' if why else ''}{why}".rstrip() for command, why in steps)


def _hints(environment: Mapping[str, str], settings: Path, *, own_user: bool) -> list[str]:
    hints = []
    if names := sorted(name for name in environment if name.startswith(PREFIX)):
        hints.append(f"Set in this shell only: {', '.join(names)}. Write what the service needs into {settings}")
    if own_user and environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE") == "LOCALHOST":
        hints.append(
            "ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST makes Fast DDS use shared memory, which is closed to programs of "
            "other users: take --user-name with the user of the robot's programs, or SUBNET"
        )
    return hints
