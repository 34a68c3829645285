"""What holds for everything that people change: a change that is based on an old version is refused."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from hypothesis import strategies as st

Step = Literal["read", "write", "create", "remove"]
STEPS = st.lists(
    st.tuples(st.sampled_from(["read", "write", "create", "remove"]), st.integers(0, 2)), min_size=4, max_size=14
)


@dataclass(frozen=True)
class Resource:
    """Something that people change.

    Attributes:
        http: The client.
        path: Where it is.
        body: Returns a body with a number in it.
        number: Returns the number of a document.
    """

    http: Any
    path: str
    body: Callable[[int], dict[str, Any]]
    number: Callable[[dict[str, Any]], int]


def require_that_nothing_is_lost(resource: Resource, steps: Sequence[tuple[Step, int]]) -> None:
    """Let three people read and change it in this order; each change depends on the version that they know."""
    http, path = resource.http, resource.path
    http.delete(path)
    present: int | None = None  # the number of who wrote it last
    seen: dict[int, tuple[str, int]] = {}  # by person, the entity tag that they know, and the number
    for number, (step, person) in enumerate(steps):
        etag, known = seen.get(person, ('"never"', -1))
        fresh = present is not None and known == present
        match step:
            case "read":
                answer = http.get(path)
                assert answer.status_code == (404 if present is None else 200)
            case "write":
                answer = http.put(path, json=resource.body(number), headers={"If-Match": etag})
                assert answer.status_code == (200 if fresh else 412), answer.text
                present = number if fresh else present
            case "create":
                answer = http.put(path, json=resource.body(number), headers={"If-None-Match": "*"})
                assert answer.status_code == (201 if present is None else 412), answer.text
                assert answer.headers.get("location") == (path if present is None else None)
                present = number if present is None else present
            case "remove":
                answer = http.delete(path, headers={"If-Match": etag})
                assert answer.status_code == (204 if present is None or fresh else 412), answer.text
                present = None if fresh else present
        if answer.status_code == 412:
            assert answer.json()["code"] == "changed_meanwhile"
        elif answer.status_code in (200, 201):
            assert resource.number(answer.json()) == present
            assert answer.headers["etag"] == answer.json()["etag"]
            seen[person] = (answer.headers["etag"], resource.number(answer.json()))
    wins = http.put(path, json=resource.body(99))  # without a condition
    assert wins.status_code == (201 if present is None else 200)
    assert resource.number(http.get(path).json()) == 99
