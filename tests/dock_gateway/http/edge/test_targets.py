"""Request lines: paths and addresses, and every way to write a stop."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.http.edge.targets import RequestLine, begins_stop, read_request_line, stop_path

STOPS = [
    b"/stop",
    b"//stop",
    b"///stop//",
    b"/stop/",
    b"/STOP",
    b"/Stop/",
    b"/stop#",
    b"/stop#now",
    b"/%73top",
    b"/%53%54%4F%50",
    b"/stop%2F",
    b"/./stop",
    b"/stop/.",
    b"/x/../stop",
    b"/../stop",
    b"/stop;v=1",
    b"/stop%20",
    b"http://127.0.0.1:8000/stop",
    b"http://robots.example/stop",
    b"https://robots.example:8443//stop/",
    b"HTTP://ROBOTS.EXAMPLE/stop",
    b"ws://robots.example/stop",
]
OTHERS = [
    b"/",
    b"/stops",
    b"/st/op",
    b"/stop/../dock",
    b"/dock",
    b"/stop%00",
    b"/%2573top",
    b"/stop/x",
    b"/x/stop",
    b"/sites/stop",
    b"/sites/berlin/robots/stop",
    b"/sites/berlin/stop/x",
    b"/sites/berlin/%2573top",
    b"*",
]


@pytest.mark.parametrize("target", STOPS)
@pytest.mark.parametrize("method", [b"POST", b"post", b"Post"])
def test_a_stop(method: bytes, target: bytes) -> None:
    line = read_request_line(method, target)
    assert (line.method, line.target) == (b"POST", b"/stop")
    assert read_request_line(method, target.partition(b"#")[0] + b"?robot=/r1#x").target == b"/stop?robot=/r1"
    assert begins_stop(method + b" " + target + b" HTTP/1.1\r\n")
    assert not begins_stop(b"GET " + target + b" HTTP/1.1\r\n")


@pytest.mark.parametrize("below", [target for target in STOPS if target.startswith(b"/")])
@pytest.mark.parametrize(
    "site", [b"/sites/berlin", b"//SITES;v=1/./Berlin", b"/x/../sites/%62erlin", b"http://a/sites/berlin"]
)
def test_a_stop_of_a_site(site: bytes, below: bytes) -> None:
    """What is a stop at a gateway is one of the site, at its hub."""
    for method in (b"POST", b"post"):
        line = read_request_line(method, site + below)
        assert (line.method, line.target) == (b"POST", b"/sites/berlin/stop")
        assert begins_stop(method + b" " + site + below + b" HTTP/1.1\r\n")
    query = site + below.partition(b"#")[0] + b"?robot=/r1#x"
    assert read_request_line(b"POST", query).target == b"/sites/berlin/stop?robot=/r1"
    assert read_request_line(b"DELETE", b"/sites/berlin" + below).target == b"/sites/berlin" + below


@pytest.mark.parametrize("target", OTHERS)
def test_what_is_no_stop(target: bytes) -> None:
    assert stop_path(b"POST", target) is None
    assert not begins_stop(b"POST " + target + b" HTTP/1.1\r\n")


@pytest.mark.parametrize("method", [b"GET", b"PUT", b"DELETE", b"STOP"])
@pytest.mark.parametrize("target", [target for target in STOPS if target.startswith(b"/")])
def test_another_method_is_passed_on_as_it_is(method: bytes, target: bytes) -> None:
    """A release of a stop, say, is what it says and nothing else."""
    assert read_request_line(method, target) == RequestLine(method, target)


@pytest.mark.parametrize(
    ("target", "path", "host"),
    [
        (b"http://a/robots?x=1", b"/robots?x=1", b"a"),
        (b"http://a:80", b"/", b"a:80"),
        (b"http://a?x=1", b"/?x=1", b"a"),
        (b"https://[::1]:8000/dock/", b"/dock/", b"[::1]:8000"),
        (b"http://a#x", b"/#x", b"a"),
        (b"ws://a:8000/ws?ticket=1", b"/ws?ticket=1", b"a:8000"),
        (b"WSS://a/ws", b"/ws", b"a"),
        (b"http://a/@b", b"/@b", b"a"),
    ],
)
def test_an_address(target: bytes, path: bytes, host: bytes) -> None:
    assert read_request_line(b"GET", target) == RequestLine(b"GET", path, host)


@pytest.mark.parametrize(
    "target",
    [
        *[b"*", b"stop", b"127.0.0.1:8000", b"ftp://a/stop", b"http:///stop", b"http:/stop", b"?x", b"http:\\\\a/stop"],
        *[b"http://user@a/stop", b"http://user:word@a", b"http://a@/stop", b"http://localhost\\@a/stop", b"http://"],
    ],
)
def test_what_is_no_target(target: bytes) -> None:
    with pytest.raises(ValueError, match="neither a path nor"):
        read_request_line(b"POST", target)


@given(
    before=st.lists(st.sampled_from(["", ".", "x/..", "..", ";a", "%2e"])),
    name=st.text("stopSTOP", min_size=4, max_size=4).filter(lambda name: name.lower() == "stop") | st.just("stop"),
    encoded=st.sets(st.integers(0, 3)),
    after=st.lists(st.sampled_from(["", "."])),
)
def test_however_it_is_written(before: list[str], name: str, encoded: set[int], after: list[str]) -> None:
    written = "".join(f"%{ord(each):02X}" if place in encoded else each for place, each in enumerate(name))
    target = "/" + "/".join([*before, written, *after])
    assert read_request_line(b"POST", target.encode()) == RequestLine(b"POST", b"/stop")
    of_site = b"/stop" if before.count("..") > 1 else b"/sites/oslo/stop"  # above the site, all are stopped
    assert read_request_line(b"POST", b"/sites/oslo" + target.encode()).target == of_site


@given(st.binary())
def test_any_bytes(target: bytes) -> None:
    try:
        line = read_request_line(b"POST", target)
    except ValueError:
        return
    assert line.target.startswith(b"/")
