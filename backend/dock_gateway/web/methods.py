"""Which methods a path has: what `OPTIONS` answers, and what a 405 says."""

from collections.abc import Callable, Iterable, Sequence

from starlette.routing import BaseRoute, Route

AllowedMethods = Callable[[str], str | None]


def allowed_methods(routes: Sequence[BaseRoute]) -> AllowedMethods:
    """A function that says which methods a path has, as the header `Allow` lists them; None for one that has none.

    A router asks each route by itself, and says of the first whose path matches which methods *it* has. The methods of
    a path are those of all routes with the same template.
    """
    found: list[Route] = [route for route in routes if isinstance(route, Route)]

    def allowed(path: str) -> str | None:
        template = next((route.path for route in found if route.path_regex.match(path)), None)
        if template is None:
            return None
        return _join(route.methods or () for route in found if route.path == template)

    return allowed


def _join(methods: Iterable[Iterable[str]]) -> str:
    return ", ".join(sorted({"OPTIONS"}.union(*methods)))
