"""Options that may stand before or after the command."""

import click


def keep_option(ctx: click.Context, parameter: click.Parameter, value: object) -> None:
    """Keep an option that may stand before or after the command, in the object of the outermost context."""
    if value and parameter.name is not None:
        ctx.find_root().ensure_object(dict)[parameter.name] = value


url_option = click.option(
    "--url",
    metavar="URL",
    expose_value=False,
    callback=keep_option,
    help="Base URL of the gateway.  [env: DOCK_GATEWAY_URL; default: http://127.0.0.1:8000]",
)
json_option = click.option(
    "--json", "as_json", is_flag=True, expose_value=False, callback=keep_option, help="Print JSON, a document a line."
)
