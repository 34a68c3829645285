"""What was frozen is still promised, and what is new is written down: see docs/compatibility.md."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.compatibility import Changes, compare
from tests.support.contract import HUB as HUB_FILE
from tests.support.contract import added_to, frozen_gateway, merged, of_gateway, of_hub, read
from tests.support.installed import needs

ADD = "run `python -m tests.support.contract --freeze`, and commit the files with the change"


def require_unchanged(found: Changes) -> None:
    """Say what has changed, and what to do."""
    text = "\n".join(found.lines())
    if found.broken:
        pytest.fail(f"what was promised is broken; only what was deprecated before may go:\n{text}", pytrace=False)
    if text:
        pytest.fail(f"{ADD}:\n{text}", pytrace=False)


def test_the_gateway_is_as_it_was_frozen() -> None:
    require_unchanged(compare(frozen_gateway(), of_gateway()))


@needs("sites")  # whose page has the metrics of a hub
def test_the_hub_is_as_it_was_frozen() -> None:
    require_unchanged(compare(read(HUB_FILE), of_hub()))


def test_every_kind_of_promise_is_frozen() -> None:
    frozen = frozen_gateway()
    methods = {method for item in frozen["paths"].values() for method in item}
    assert {"get", "put", "post", "delete", "set", "run"} <= methods
    assert frozen["paths"]["dock-gateway dock"]["run"]["parameters"]
    assert (
        "port"
        in frozen["paths"]["settings"]["set"]["requestBody"]["content"]["application/json"]["schema"]["properties"]
    )
    assert {"error robot_not_found", "/ws/feedback StatusEvent", "metric dock_gateway_goals_running"} <= frozen[
        "names"
    ].keys()


DOCUMENTS = st.recursive(
    st.integers() | st.text(max_size=2) | st.lists(st.integers(0, 3), unique=True, max_size=3),
    lambda inner: st.dictionaries(st.sampled_from("abc"), inner, max_size=3),
)


@given(st.dictionaries(st.sampled_from("abc"), DOCUMENTS), st.dictionaries(st.sampled_from("abcd"), DOCUMENTS))
def test_what_an_extension_adds_is_merged_again(base: dict[str, Any], more: dict[str, Any]) -> None:
    whole = merged(base, more)
    again = merged(base, added_to(base, whole))
    assert again == whole


def with_name(**names: str) -> dict[str, Any]:
    return {"paths": {}, "names": names}


@pytest.mark.parametrize(
    ("before", "after", "line"),
    [
        (with_name(a="1"), with_name(a="1"), None),
        (with_name(), with_name(a="1"), "added: a"),
        (with_name(a="1"), with_name(), "broken: a: is gone"),
        (with_name(a="1"), with_name(a="2"), "broken: a: was 1, is 2"),
    ],
)
def test_names(before: dict[str, Any], after: dict[str, Any], line: str | None) -> None:
    assert compare(before, after).lines() == ([] if line is None else [line])


def option(**more: Any) -> dict[str, Any]:
    described = {"in": "option", "name": "--json", "required": False, "schema": {"type": "flag"}}
    return {"paths": {"dock-gateway dock": {"run": {"parameters": [described], "responses": {}, **more}}}}


def test_a_command_that_is_gone_and_one_that_was_deprecated() -> None:
    gone: dict[str, Any] = {"paths": {}}
    assert compare(option(), gone).lines() == ["broken: RUN dock-gateway dock: is gone"]
    assert compare(option(parameters=[]), option()).lines() == ["added: RUN dock-gateway dock: option --json"]
    assert compare(option(), option(parameters=[])).lines() == ["broken: RUN dock-gateway dock: option --json is gone"]
    assert compare(option(), option(deprecated=True)).lines() == ["deprecated: RUN dock-gateway dock"]
    assert compare(option(deprecated=True), gone).lines() == []
