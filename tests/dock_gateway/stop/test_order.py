"""What a request to stop robots means, whatever it says."""

from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.datastructures import QueryParams

from dock_gateway.core.access import ANYBODY
from dock_gateway.core.errors import MalformedRequest
from dock_gateway.core.namespace import ALL_ROBOTS, is_namespace, normalize_namespace
from dock_gateway.stop.order import (
    FIELDS,
    MAX_ERRORS,
    MAX_NAME,
    MAX_ROBOTS,
    UNCLEAR,
    StopOrder,
    is_stop_service,
    read_order,
    says,
)

ADA = replace(ANYBODY, name="ada")
ALL = (ALL_ROBOTS,)
UNREADABLE = MalformedRequest("the body is not JSON", code="malformed_json")


@dataclass(frozen=True)
class Means:
    """What a request means; `wrong` are the code of the warning and the fields of its errors."""

    robots: tuple[str, ...] = ALL
    latch: bool = True
    by: str | None = None
    unclear: bool = False
    wrong: tuple[str, ...] = ()


INVALID = "invalid_field"
ONE, TWO = ("/robot1",), ("/robot1", "/robot2")
MANY = [f"/robot{number}" for number in range(MAX_ROBOTS)]
# What is clear stops what it names.
CLEAR: list[tuple[str, object, Means]] = [
    ("", {}, Means()),
    ("", {"robot": None, "by": None}, Means()),
    ("", {"robot": []}, Means()),
    ("", {"robot": [None]}, Means()),
    ("", {"robot": "/"}, Means()),
    ("", {"latch": False}, Means(latch=False)),
    ("", {"by": " Ada "}, Means(by="Ada")),
    ("", {"robot": "/robot1", "latch": False, "by": "Ada"}, Means(ONE, latch=False, by="Ada")),
    ("", {"robot": "robot1"}, Means(ONE)),
    ("", {"robot": " /robot1/ "}, Means(ONE)),
    ("", {"robot": ["/robot1", "robot2", "/robot1", None]}, Means(TWO)),
    ("", {"robot": ["/robot1", "/"]}, Means(("/robot1", "/"))),
    ("robot=/robot1", {}, Means(ONE)),
    ("robot=/robot1&robot=robot2", {}, Means(TWO)),
    ("robot=/robot1", {"robot": "/robot2", "latch": False}, Means(TWO, latch=False)),
    ("", {"robot": MANY}, Means(tuple(MANY))),
]
# What is wrong besides the robots leaves them as they are, and the stop is latched.
PARTLY: list[tuple[str, object, Means]] = [
    ("", {"latch": "no"}, Means(wrong=(INVALID, "latch"))),
    ("", {"latch": 0}, Means(wrong=(INVALID, "latch"))),
    ("", {"latch": None}, Means(wrong=(INVALID, "latch"))),
    ("", {"by": "", "latch": False}, Means(wrong=(INVALID, "by"))),
    ("", {"by": "a" * (MAX_NAME + 1)}, Means(wrong=(INVALID, "by"))),
    ("", {"by": 7, "latch": 7}, Means(wrong=(INVALID, "latch", "by"))),
    ("", {"robot": "/robot1", "latch": "no"}, Means(ONE, wrong=(INVALID, "latch"))),
    ("", {"robot": "/robot1", "latch": False, "why": "fire"}, Means(ONE, wrong=(INVALID, "why"))),
    ("robot=/robot1", [], Means(ONE, wrong=(INVALID, ""))),
    ("robot=/robot1", None, Means(ONE, wrong=(INVALID, ""))),
    ("robot=/robot1", UNREADABLE, Means(ONE, wrong=("malformed_json",))),
    ("robot=/robot1&latch=false", {"latch": False}, Means(ONE, wrong=(INVALID, "latch"))),
    ("robot=/robot1", MappingProxyType({"robot": "/robot2"}), Means(TWO, wrong=(INVALID, ""))),
]
# What may have named robots, and cannot be understood, stops all.
NOT_CLEAR: list[tuple[str, object, Means]] = [
    ("", UNREADABLE, Means(unclear=True, wrong=("malformed_json",))),
    ("", None, Means(unclear=True, wrong=(INVALID, ""))),
    ("", "/robot1", Means(unclear=True, wrong=(INVALID, ""))),
    ("", ["/robot1"], Means(unclear=True, wrong=(INVALID, ""))),
    ("", {"robots": "/robot1", "latch": False}, Means(unclear=True, wrong=(INVALID, "robots"))),
    ("", {1: 2}, Means(unclear=True, wrong=("malformed_request",))),
    ("", {"robot": "robot 1"}, Means(unclear=True, wrong=(INVALID, "robot"))),
    ("", {"robot": ""}, Means(unclear=True, wrong=(INVALID, "robot"))),
    ("", {"robot": 1}, Means(unclear=True, wrong=(INVALID, "robot"))),
    ("", {"robot": {"name": "/robot1"}}, Means(unclear=True, wrong=(INVALID, "robot"))),
    ("", {"robot": ["/robot1", "robot 2"]}, Means(unclear=True, wrong=(INVALID, "robot"))),
    ("", {"robot": ["/robot1", ["/robot2"]], "latch": False}, Means(unclear=True, wrong=(INVALID, "robot"))),
    ("", {"robot": "/robot1" * 100}, Means(unclear=True, wrong=(INVALID, "robot"))),
    ("", {"robot": ["/robot1"] * (MAX_ROBOTS + 1)}, Means(unclear=True, wrong=(INVALID, "robot"))),
    ("robto=/robot1", {}, Means(unclear=True, wrong=(INVALID, "robto"))),
    ("robot=", {}, Means(unclear=True, wrong=(INVALID, "robot"))),
    ("robot=/robot1&robot=*", {"robot": "/robot2"}, Means(unclear=True, wrong=(INVALID, "robot"))),
    ("robto=/robot1", {"latch": 7, "by": "Ada"}, Means(by="Ada", unclear=True, wrong=(INVALID, "robto", "latch"))),
]


def wrong_in(order: StopOrder) -> tuple[str, ...]:
    """The code of a warning and the fields of its errors; empty if there is no warning."""
    warning = order.warning()
    if warning is None:
        return ()
    assert warning["detail"].endswith(UNCLEAR) is order.unclear
    return warning["code"], *(error["path"] for error in warning.get("errors", ()))


@pytest.mark.parametrize(("query", "request_", "means"), [*CLEAR, *PARTLY, *NOT_CLEAR])
def test_what_it_means(query: str, request_: object, means: Means) -> None:
    order = read_order(ANYBODY, request_, query=QueryParams(query) if query else None)
    assert Means(order.robots, order.latch, order.by, order.unclear, wrong_in(order)) == means


@pytest.mark.parametrize("request_", [{}, {"by": "Bob"}, {"by": 7}, {"robot": 7}, None, UNREADABLE])
def test_who_is_known_is_named_whatever_the_request_says(request_: object) -> None:
    assert read_order(ADA, request_).by == "ada"


def test_errors_that_were_found_before_come_first_and_latch_nothing() -> None:
    late = MalformedRequest("the header is wrong", code="malformed_header")
    order = read_order(ANYBODY, {"latch": False, "robot": "/robot1"}, wrong=[late])
    assert (order.robots, order.latch, wrong_in(order)) == (ONE, False, ("malformed_header",))
    both = read_order(ANYBODY, {"latch": 7}, wrong=[late]).warning(UNREADABLE)
    assert both is not None
    assert (both["code"], both["detail"]) == (
        "malformed_json",
        "the body is not JSON; the header is wrong; latch: expected true or false, got 7",
    )


def test_a_warning_lists_no_more_errors_than_fit() -> None:
    unknown = dict.fromkeys(map(str, range(100)), "")
    order = read_order(ANYBODY, unknown, query=QueryParams(unknown))
    warning = order.warning()
    assert warning is not None
    assert len(warning["errors"]) == MAX_ERRORS
    assert order.unclear


NAMES = st.sampled_from(["/robot1", "robot2", "/", "", "robot 1", "/robot1/", "a" * 300]) | st.text()
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.binary() | NAMES,
    lambda values: st.lists(values) | st.dictionaries(st.text(), values),
    max_leaves=10,
)
KEYS = st.sampled_from(FIELDS) | st.text()
REQUESTS = (
    VALUES
    | st.dictionaries(KEYS, VALUES)
    | st.dictionaries(KEYS | st.integers() | st.none(), VALUES)
    | st.fixed_dictionaries({}, optional={"robot": NAMES | st.lists(NAMES | st.none()), "latch": VALUES, "by": VALUES})
    | st.just(UNREADABLE)
    | st.dictionaries(KEYS, VALUES).map(MappingProxyType)
    | st.dictionaries(KEYS, VALUES).map(OrderedDict)
)
QUERIES = st.none() | st.lists(st.tuples(KEYS, NAMES), max_size=5).map(QueryParams)


def understood(request_: object, query: QueryParams | None) -> list[str] | None:
    """The robots that are named, each as it must be; None if what is named, or may be, is not all understood."""
    named: list[Any] = [] if query is None else query.getlist("robot")
    if isinstance(request_, Mapping):
        robot = request_.get("robot")
        named += robot if isinstance(robot, list) else [robot]
    names = [name.strip() if isinstance(name, str) else "" for name in named if name is not None]
    namespaces = list(map(normalize_namespace, names))
    return namespaces if all(names) and all(map(is_namespace, namespaces)) else None


@given(REQUESTS, QUERIES)
def test_it_never_fails_and_what_cannot_be_understood_stops_all(request_: Any, query: QueryParams | None) -> None:
    order = read_order(ANYBODY, request_, query=query)
    robots = understood(request_, query)
    plain = isinstance(request_, dict) and request_.keys() <= set(FIELDS) and not set(query or ()) - {"robot"}
    if robots:
        assert order.robots == tuple(dict.fromkeys(robots))
        assert not order.unclear
    else:
        assert order.robots == ALL
        assert order.unclear is (robots is None or not plain)
    assert (order.warning() is None) is (order.wrong == ())
    assert order.wrong or (plain and order.latch is request_.get("latch", True))
    assert order.latch or not order.wrong, "what is not understood is latched"
    assert not order.unclear or order.wrong, "all robots are stopped with a reason"


@pytest.mark.parametrize("name", ["/dock_gateway/stop", "dock_gateway/stop/", " /Dock_Gateway//STOP "])
def test_the_service_of_a_stop_however_it_is_written(name: str) -> None:
    assert is_stop_service(name)


@pytest.mark.parametrize("name", ["/dock_gateway/stops", "/stop", "", None, 7, ["/dock_gateway/stop"]])
def test_what_is_no_service_of_a_stop(name: object) -> None:
    assert not is_stop_service(name)


def test_a_stop_in_a_message_that_cannot_be_decoded() -> None:
    assert says('{"op": "stop", "robot": [[[', "op", "stop")
    assert says(b'{"id":"\xff","op" :\n"stop"', "op", "stop")
    assert not says('{"op": "stopped"', "op", "stop")
    assert not says('{"reason": "stop"', "op", "stop")
