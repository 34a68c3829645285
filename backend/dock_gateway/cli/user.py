"""`dock-gateway user create`, `list`, `passwd`, `disable`, `enable`, `delete`: people who log in with a password.

They are read and written in the history's database, whether a gateway runs or not: the first admin is created here. A
running gateway knows changes 2 s later.
"""

import sys

import click

from dock_gateway.cli.accounts import database_option, describe_limits, grant_options, make_grant, with_logins
from dock_gateway.cli.groups import CommandGroup


def read_name(_: click.Context, __: click.Parameter, name: str) -> str:
    """Return the argument NAME.

    Raises:
        click.BadParameter: It cannot be the name of a user.
    """
    from dock_gateway.access.users import USER_NAME  # noqa: PLC0415 - takes a second

    if not USER_NAME.fullmatch(name):
        raise click.BadParameter("it is up to 60 lower-case letters and digits, with . _ - @ + between them")
    return name


name_argument = click.argument("name", callback=read_name)


def read_password() -> str:
    """Return a password: typed twice at a terminal, else the first line of the input.

    Raises:
        click.UsageError: It is too short, too long or not UTF-8.
    """
    from dock_gateway.access.passwords import MAX_PASSWORD, MIN_PASSWORD  # noqa: PLC0415 - takes a second

    if sys.stdin.isatty():
        password: str = click.prompt("Password", hide_input=True, confirmation_prompt="The same again")
    else:
        line = sys.stdin.buffer.readline()
        try:
            password = line.decode().rstrip("\r\n")
        except UnicodeDecodeError:
            raise click.UsageError("the password is not UTF-8") from None
    if not MIN_PASSWORD <= len(password) <= MAX_PASSWORD:
        raise click.UsageError(
            f"a password has {MIN_PASSWORD} to {MAX_PASSWORD} characters; this one has {len(password)}"
        )
    return password


@click.group(cls=CommandGroup)
def user() -> None:
    """Create, list, change and delete users, who log in with a name and a password."""


@user.command()
@name_argument
@grant_options
@database_option
def create(name: str, role: str, database_url: str | None, **limits: tuple[str, ...]) -> None:
    """Create the user NAME. The password is asked for, or read from the input."""
    grant, password = make_grant(role, limits), read_password()
    with_logins(database_url, lambda logins: logins.accounts.add(name, grant, password))
    click.echo(f"created {name}, who is {'an' if role[0] in 'ao' else 'a'} {role}")


@user.command()
@name_argument
@database_option
def passwd(name: str, database_url: str | None) -> None:
    """Set the password of the user NAME, and log them out everywhere."""
    password = read_password()
    with_logins(database_url, lambda logins: logins.accounts.edit(name, password=password))
    click.echo(f"{name} has a new password, and is logged out everywhere")


@user.command()
@name_argument
@database_option
def disable(name: str, database_url: str | None) -> None:
    """Log the user NAME out everywhere, and refuse their logins from now on."""
    with_logins(database_url, lambda logins: logins.accounts.edit(name, disabled=True))
    click.echo(f"{name} is logged out everywhere, and cannot log in")


@user.command()
@name_argument
@database_option
def enable(name: str, database_url: str | None) -> None:
    """Let the user NAME log in again."""
    with_logins(database_url, lambda logins: logins.accounts.edit(name, disabled=False))
    click.echo(f"{name} can log in again")


@user.command()
@name_argument
@database_option
def delete(name: str, database_url: str | None) -> None:
    """Delete the user NAME, and log them out everywhere."""
    with_logins(database_url, lambda logins: logins.accounts.remove(name))
    click.echo(f"deleted {name}")


@user.command(name="list")
@database_option
def list_users(database_url: str | None) -> None:
    """List all users."""
    for each in with_logins(database_url, lambda logins: logins.accounts.documents(), changed=False):
        last = each["logged_in_at"]
        login = "never logged in" if last is None else f"logged in {last:%Y-%m-%d %H:%M} UTC"
        state = ", disabled" if each["disabled"] else ""
        click.echo(f"{each['role']:10}  {each['name']}  ({login}{state}{describe_limits(each)})")
