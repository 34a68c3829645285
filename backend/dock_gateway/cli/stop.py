"""`dock-gateway stop` and `release`. They import little: a stop must not wait for what it does not need."""

import sys
from collections.abc import Sequence

import click

from dock_gateway.cli.asking import asks, for_robot, gateway, one_robot, print_json, wanted
from dock_gateway.core.log_config import printable

# Seconds that a stop may take, in addition to those that the gateway waits for action servers.
STOP_WITHIN = 4.0


class StopCommand(click.Command):
    """A command line that stops robots although it is not valid: all of them then."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the arguments; of those that are not valid, only the address."""
        url = [arg for at, arg in enumerate(args) if arg.startswith("--url=") or (arg == "--url" and args[at + 1 :])]
        if url and url[0] == "--url":
            url.insert(1, args[args.index("--url") + 1])
        try:
            return super().parse_args(ctx, args)
        except click.UsageError as error:
            click.echo(printable(f"{error.format_message()} Stopping all robots."), err=True)
            return super().parse_args(ctx, url[:2] if url[:1] == ["--url"] else url[:1])


@click.command(cls=StopCommand, context_settings={"ignore_unknown_options": True})
@click.argument("names", metavar="[ROBOT]...", nargs=-1)
@click.option("--by", help="Your name, shown to others.")
@click.option("--no-latch", is_flag=True, help="Accept new goals again immediately.")
@click.option(
    "--robot", "robots", multiple=True, help="Namespace of a robot, such as /robot1; several to stop several."
)
@asks
def stop(names: tuple[str, ...], robots: tuple[str, ...], no_latch: bool, by: str | None) -> None:
    """Stop robots, all by default: zero velocity, every goal is canceled, and none is sent until `release`.

    The gateway runs on; Ctrl-C ends it where it runs. If the options are not valid, all robots are stopped.
    """
    unknown = [name for name in names if name.startswith("-")]
    if unknown:
        click.echo(printable(f"Unknown option {unknown[0]}. Stopping all robots."), err=True)
    try:
        with gateway(timeout=STOP_WITHIN) as client:
            report = client.stop(*([] if unknown else [*robots, *names]), latch=not no_latch, by=by)
    except click.ClickException as error:
        advice = "the stop is NOT confirmed; use the robots' own emergency stop if they move"
        raise click.ClickException(f"{advice}: {error.message}") from None
    if wanted("as_json"):
        print_json(report)
        sys.exit(1 if report.failed or report.unconfirmed else 0)
    click.echo(printable(describe(report.stopped, report.canceling)))
    if report.not_stopped:
        click.echo(printable(f"not stopped: {', '.join(report.not_stopped)}"))
    if report.warning:
        click.echo(printable(f"warning: {report.warning['detail']}"), err=True)
    if report.stop["latched"]:
        click.echo("goals are refused until the stop is released: dock-gateway release")
    for failure in report.failed:
        click.echo(printable(f"{failure['action_name'] or failure['robot']}: {failure['detail']}"), err=True)
    for name in report.unconfirmed:
        click.echo(f"{name}: the action server has not answered yet", err=True)
    if report.failed or report.unconfirmed:
        sys.exit(1)


def describe(stopped: Sequence[str], canceling: Sequence[str]) -> str:
    """Return in a line who was stopped, and how many goals are canceled."""
    if not stopped:
        return "no robot was stopped: there is none that you may see"
    names = ", ".join("/ (the robot without a namespace)" if name == "/" else name for name in stopped)
    goals = f"canceling {len(canceling)} {'goal' if len(canceling) == 1 else 'goals'}" if canceling else "no goal ran"
    return f"stopped {names}: zero velocity; {goals}"


@click.command()
@for_robot
@asks
def release(name: str | None, robot: str | None) -> None:
    """Release a stop, of all robots by default: new goals are accepted again. This moves no robot."""
    with gateway() as client:
        client.release(one_robot(name, robot))
    if wanted("as_json"):
        print_json({"released": True})
    else:
        click.echo("released")
