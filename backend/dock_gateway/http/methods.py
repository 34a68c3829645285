"""The methods of each path, for `OPTIONS` and 405 responses."""

from collections.abc import Callable, Iterable, Sequence

from starlette.routing import BaseRoute, Route

AllowedMethods = Callable[[str], str | None]


def allowed_methods(routes: Sequence[BaseRoute]) -> AllowedMethods:
    """Return a function that maps a path to its `Allow` header, or to None if it has no route.

    Starlette's router reports only the methods of the first route whose path matches. The methods of a path are those
    of all routes with the same template.
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
