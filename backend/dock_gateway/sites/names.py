"""Names of a site's ROS graph as its hub writes them: with the site in front, as if it were a namespace. Pure."""

from dataclasses import replace

from dock_gateway.core.grant import Grant

ANY = "*"
# A pattern that no name matches: an empty limit would cover everything.
NOTHING = "/"


def to_hub(site: str, name: str) -> str:
    """Return the hub's name of a robot, an action or a topic: `/berlin/robot1` of `/robot1`, `/berlin` of `/`."""
    return f"/{site}{name}".rstrip("/")


def to_site(site: str, name: str) -> str | None:
    """Return the site's own name of what the hub calls `name`; None if it is not of this site."""
    prefix = f"/{site}"
    if name == prefix:
        return "/"
    return name.removeprefix(prefix) if name.startswith(f"{prefix}/") else None


def site_grant(grant: Grant, site: str) -> Grant | None:
    """Return what a grant at the hub allows at a site, in the site's own names; None if it covers none of its robots.

    It covers exactly what the grant does: `hub_grant.covers_robot(to_hub(site, name))` is
    `site_grant.covers_robot(name)`, and so for actions and topics.
    """
    robots = _robots(grant.robots, f"/{site}")
    if grant.robots and not robots:
        return None
    actions, topics = (_rests(limit, f"/{site}") for limit in (grant.actions, grant.topics))
    return replace(
        grant,
        robots=robots,
        actions=actions or (NOTHING,) * bool(grant.actions),
        topics=topics or (NOTHING,) * bool(grant.topics),
    )


def _robots(patterns: tuple[str, ...], prefix: str) -> tuple[str, ...]:
    """Return the rests of patterns of namespaces. Each stands for the names below it; `/` for no name below a site."""
    below = tuple(f"{pattern.rstrip('/')}/*" for pattern in patterns if pattern.rstrip("/"))
    return tuple(dict.fromkeys(rest.removesuffix("/*") or ANY for rest in _rests(below, prefix)))


def _rests(patterns: tuple[str, ...], prefix: str) -> tuple[str, ...]:
    """Return patterns that match a name exactly if one of `patterns` matches it with `prefix` in front."""
    rests = (rest for pattern in patterns for rest in _consume(pattern, prefix))
    return tuple(dict.fromkeys(rest for rest in rests if rest.startswith(("/", ANY))))


def _consume(pattern: str, prefix: str) -> list[str]:
    """Return what can be left of a pattern when it has matched a prefix."""
    rests = {pattern}
    for character in prefix:
        rests = {rest for each in rests for rest in _step(each, character)}
    return sorted(rests)


def _step(pattern: str, character: str) -> set[str]:
    """Return what can be left of a pattern when it has matched a character."""
    if pattern.startswith(ANY):
        return {pattern} | _step(pattern[1:], character)
    return {pattern[1:]} if pattern.startswith(character) else set()
