"""Which robots there are, wherever they are found."""

from typing import Protocol


class Robots(Protocol):
    """The robots that requests may name.

    Attributes:
        default_namespace: The robot that is meant where none is named.
    """

    default_namespace: str

    def namespaces(self) -> list[str]:
        """Return the namespaces of all robots, sorted."""

    def find(self, namespace: str | None = None) -> str:
        """Return the namespace of a robot as it is written in answers; default: that of the configured one.

        Raises:
            NotFound: `robot_not_found`.
        """
