"""Commands that have commands of their own."""

import click

# Characters of a command in the help of its group: all of its first sentence, which is wrapped, not cut.
WHOLE = 1000


class CommandGroup(click.Group):
    """A group whose help has the whole first sentence of each of its commands."""

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands."""
        found = [(name, self.get_command(ctx, name)) for name in self.list_commands(ctx)]
        with formatter.section("Commands"):
            formatter.write_dl(
                [(name, command.get_short_help_str(WHOLE)) for name, command in found if command and not command.hidden]
            )
