"""Bodies: one that is not there means something only where that is documented."""

import codecs
import gzip

import pytest
from fastapi import FastAPI, Request
from starlette.testclient import TestClient

from dock_gateway.core.errors import InvalidField, MalformedRequest
from dock_gateway.http.requests import (
    GraphName,
    check_key,
    decode_json,
    read_goal_id,
    read_json,
    read_name,
)
from tests.support.requests import request


async def test_an_empty_body_is_refused() -> None:
    with pytest.raises(InvalidField) as refused:
        await read_json(request(b""))
    assert refused.value.extra["errors"][0]["expected"] == "an object, {} for the defaults"


async def test_an_empty_body_where_it_has_a_meaning() -> None:
    assert await read_json(request(b""), empty={"order": 1}) == {"order": 1}
    assert await read_json(request(b""), empty={}) == {}


async def test_a_compressed_body_is_refused_as_such() -> None:
    with pytest.raises(MalformedRequest) as refused:
        await read_json(request(gzip.compress(b"{}"), [(b"content-encoding", b"gzip")]))
    assert (refused.value.status, refused.value.code) == (415, "unsupported_media_type")
    assert "gzip" in refused.value.detail
    assert await read_json(request(b"{}", [(b"content-encoding", b"identity")])) == {}


@pytest.mark.parametrize(("body", "value"), [(b"null", None), (b"[]", []), (b"0", 0), (b'""', ""), (b"false", False)])
async def test_what_is_false_is_not_empty(body: bytes, value: object) -> None:
    assert await read_json(request(body), empty={"order": 1}) == value


async def test_a_byte_order_mark_is_ignored() -> None:
    """Editors and shells on Windows write one."""
    assert await read_json(request(codecs.BOM_UTF8 + b'{"order": 1}')) == {"order": 1}
    assert decode_json('\ufeff{"order": "\ufeff"}', "the message") == {"order": "\ufeff"}
    for text, why in (
        (codecs.BOM_UTF8 * 2 + b"{}", "not JSON"),
        ("{}".encode("utf-16"), "UTF-16"),
        (codecs.BOM_UTF8, "not"),
    ):
        with pytest.raises(MalformedRequest, match=why):
            await read_json(request(text))


def test_a_name_on_the_graph_may_have_its_slash() -> None:
    """What a route and what the check of a grant get is the same name."""

    async def names(name: GraphName, request: Request) -> list[str]:
        return [name, request.path_params["name"]]

    app = FastAPI()
    app.get("/actions/{name:graph_name}/goals")(names)
    with TestClient(app) as client:
        for path, name in (("robot1/dock", "robot1/dock"), ("%2Frobot1%2Fdock", "robot1/dock"), ("//dock", "/dock")):
            assert client.get(f"/actions/{path}/goals").json() == [name, name]
        for nothing in ("", "/", "//"):
            assert client.get(f"/actions{nothing}/goals").status_code == 404


@pytest.mark.parametrize(("value", "name"), [("Ada", "Ada"), (" Ada L. ", "Ada L."), ("Ä" * 10, "Ä" * 10)])
def test_a_name(value: str, name: str) -> None:
    assert read_name(value, 10) == name


@pytest.mark.parametrize(
    "value", ["", " \t", "a" * 11, " " * 8 + "Ada", "a\nb", "a\0", "\u2028", "a\u202eb", "\u200b", 7, None, ["Ada"]]
)
def test_what_is_no_name(value: object) -> None:
    with pytest.raises(InvalidField) as refused:
        read_name(value, 10)
    (error,) = refused.value.extra["errors"]
    assert (error["path"], error["expected"]) == ("by", "1 to 10 characters, in one line")


@pytest.mark.parametrize("key", ["", "k" * 201, "key\0"])
def test_what_is_no_idempotency_key(key: str) -> None:
    with pytest.raises(InvalidField) as refused:
        check_key(key, "idempotency_key")
    (error,) = refused.value.extra["errors"]
    assert (error["path"], error["expected"]) == ("idempotency_key", "1 to 200 characters, without NUL")


@pytest.mark.parametrize("text", ["7D9C1C9E-0000-4000-8000-00000000000A", "7d9c1c9e00004000800000000000000a"])
def test_a_goal_id_as_others_write_it(text: str) -> None:
    assert read_goal_id(text) == "7d9c1c9e-0000-4000-8000-00000000000a"


@pytest.mark.parametrize(
    "text", ["", "1234", "{7d9c1c9e-0000-4000-8000-00000000000a}", "7d9c1c9e" * 4 + "\n", "\u0661" * 32]
)
def test_what_is_no_goal_id(text: str) -> None:
    with pytest.raises(InvalidField):
        read_goal_id(text)


@pytest.mark.parametrize("text", [b"[%s]" % b",".join([b"{}"] * 20_000), b"[" * 10_001 + b"{" * 10_000])
def test_json_with_too_many_parts_is_refused_before_it_is_decoded(text: bytes) -> None:
    with pytest.raises(MalformedRequest, match="the body has more than 20,000 objects and arrays") as refused:
        decode_json(text, "the body")
    assert (refused.value.status, refused.value.code) == (413, "body_too_large")
    assert decode_json(b"[%s]" % b",".join([b"1"] * 20_000), "the body") == [1] * 20_000
