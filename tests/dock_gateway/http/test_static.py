"""Files are sent in the encoding that the client accepts, and each encoding decodes to the same bytes."""

import asyncio
import gzip
import http.client
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.applications import Starlette
from starlette.routing import Mount

from dock_gateway.http.static import CompressedFiles, choose_encoding
from tests.support.edge import serving

SCRIPT = b"const words = ['dock', 'undock'];\n" * 200
# What the build writes with Node. The gateway never reads it, so any bytes will do.
BROTLI = b"as brotli packs it"
DECODE: dict[str | None, Callable[[bytes], bytes]] = {
    None: bytes,
    "gzip": gzip.decompress,
    "br": lambda body: SCRIPT if body == BROTLI else body,
}
CACHE = {"Cache-Control": "public, max-age=31536000, immutable"}


@dataclass(frozen=True)
class Answer:
    status: int
    headers: dict[str, str]
    body: bytes


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "a.js").write_bytes(SCRIPT)
    (tmp_path / "a.js.br").write_bytes(BROTLI)
    (tmp_path / "a.js.gz").write_bytes(gzip.compress(SCRIPT))
    (tmp_path / "small.svg").write_bytes(b"<svg/>")
    return tmp_path


def ask(folder: Path, path: str, *requests: dict[str, str], method: str = "GET") -> list[Answer]:
    """Send requests through the gateway's server; nothing decodes the bodies."""

    def send(port: int) -> list[Answer]:
        answers = []
        for headers in requests:
            connection = http.client.HTTPConnection("127.0.0.1", port, timeout=30)
            # Without this, http.client accepts only identity by itself.
            connection.putrequest(method, path, skip_accept_encoding=True)
            for name, value in headers.items():
                connection.putheader(name, value)
            connection.endheaders()
            response = connection.getresponse()
            found = {name.lower(): value for name, value in response.getheaders()}
            answers.append(Answer(response.status, found, response.read()))
            connection.close()
        return answers

    async def run() -> list[Answer]:
        app = Starlette(routes=[Mount("/", CompressedFiles(folder, CACHE))])
        async with serving(app) as edge:
            return await asyncio.to_thread(send, edge.port)

    return asyncio.run(run())


@pytest.mark.parametrize(
    ("accept", "encoding"),
    [
        (None, None),
        ("", None),
        ("gzip, deflate, br, zstd", "br"),
        ("gzip", "gzip"),
        ("GZIP;Q=0.5", "gzip"),
        ("br;q=0.1, gzip;q=0.9", "gzip"),
        ("br;q=0, gzip;q=0, *", None),
        ("*", "br"),
        ("br;q=0, *;q=0.5", "gzip"),
        ("identity, br;q=0.5", None),
        ("zstd, deflate", None),
        ("identity;q=0, *;q=0", None),
        ("br;q=2, gzip;q=nan, ;;,", None),
    ],
)
def test_the_encoding_that_is_accepted(folder: Path, accept: str | None, encoding: str | None) -> None:
    headers = {} if accept is None else {"Accept-Encoding": accept}
    (answer,) = ask(folder, "/a.js", headers)
    assert answer.status == 200
    assert answer.headers.get("content-encoding") == encoding
    assert DECODE[encoding](answer.body) == SCRIPT
    assert int(answer.headers["content-length"]) == len(answer.body)
    assert answer.headers["content-type"].startswith("text/javascript")
    assert answer.headers["vary"] == "Accept-Encoding"
    assert answer.headers["cache-control"] == CACHE["Cache-Control"]


def test_a_file_without_a_compressed_form_is_sent_as_it_is(folder: Path) -> None:
    (answer,) = ask(folder, "/small.svg", {"Accept-Encoding": "br, gzip"})
    assert (answer.body, answer.headers.get("content-encoding")) == (b"<svg/>", None)
    assert answer.headers["vary"] == "Accept-Encoding"


def test_each_encoding_has_a_tag_of_its_own(folder: Path) -> None:
    codings = ("identity", "gzip", "br")
    first = ask(folder, "/a.js", *({"Accept-Encoding": coding} for coding in codings))
    tags = {coding: answer.headers["etag"] for coding, answer in zip(codings, first, strict=True)}
    assert len(set(tags.values())) == 3
    pairs = [(coding, known) for coding in codings for known in codings]
    again = ask(
        folder, "/a.js", *({"Accept-Encoding": coding, "If-None-Match": tags[known]} for coding, known in pairs)
    )
    for (coding, known), answer in zip(pairs, again, strict=True):
        assert answer.status == (304 if coding == known else 200)
        assert answer.headers["etag"] == tags[coding]
        assert answer.headers["vary"] == "Accept-Encoding"
        assert bool(answer.body) == (coding != known)


def test_a_file_of_another_version_has_another_tag_even_with_its_size_and_time(tmp_path: Path) -> None:
    """An installer or an image may give all files the same time, and the names in a page have the same lengths."""
    tags = set()
    for version in ("1", "2"):
        folder = tmp_path / version
        folder.mkdir()
        (folder / "index.html").write_text(f"index-{version}.js")
        os.utime(folder / "index.html", (0, 0))
        tags.add(ask(folder, "/index.html", {})[0].headers["etag"])
    assert len(tags) == 2


def test_head_has_the_headers_of_get(folder: Path) -> None:
    for coding in ("identity", "gzip", "br"):
        (got,) = ask(folder, "/a.js", {"Accept-Encoding": coding})
        (head,) = ask(folder, "/a.js", {"Accept-Encoding": coding}, method="HEAD")
        assert (head.status, head.body) == (200, b"")
        assert head.headers | {"date": ""} == got.headers | {"date": ""}


WEIGHT = st.one_of(st.none(), st.integers(0, 1000).map(lambda thousandths: thousandths / 1000))


@given(
    weights=st.dictionaries(st.sampled_from(["br", "gzip", "identity", "*", "zstd"]), WEIGHT),
    available=st.sampled_from([(), ("br",), ("gzip",), ("br", "gzip")]),
)
def test_no_accepted_encoding_weighs_more(weights: dict[str, float | None], available: tuple[str, ...]) -> None:
    parts = (name if weight is None else f"{name};q={weight:.3f}" for name, weight in weights.items())
    known = {name: 1.0 if weight is None else weight for name, weight in weights.items()}
    chosen = choose_encoding(", ".join(parts), available)
    assert chosen in {*available, "identity"}
    if chosen != "identity":
        weight = known.get(chosen, known.get("*", 0.0))
        assert weight > 0
        assert all(known.get(other, known.get("*", 0.0)) <= weight for other in (*available, "identity"))


@given(st.text())
def test_no_header_is_too_odd(header: str) -> None:
    assert choose_encoding(header, ("br", "gzip")) in {"br", "gzip", "identity"}
