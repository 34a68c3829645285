"""Addresses of NATS servers: passwords stay in them."""

import pytest

from dock_gateway.sites.servers import read_server


def test_a_url_with_a_password() -> None:
    server = read_server("tls://alice:s%40cret%2F1@nats.example.com:4223")
    assert (server.user, server.password, server.host, server.port) == ("alice", "s@cret/1", "nats.example.com", 4223)
    assert str(server) == "tls://nats.example.com:4223"
    assert "cret" not in repr(server)


@pytest.mark.parametrize(
    ("url", "text"),
    [
        ("nats://localhost", "nats://localhost:4222"),
        ("nats://127.0.0.2:1", "nats://127.0.0.2:1"),
        ("nats://[::1]", "nats://[::1]:4222"),
        ("nats://10.0.0.1/", "nats://10.0.0.1:4222"),
        ("nats://localhost.example.com", "nats://localhost.example.com:4222"),
        (" tls://10.0.0.1 ", "tls://10.0.0.1:4222"),
    ],
)
def test_the_text_of_a_server(url: str, text: str) -> None:
    assert str(read_server(url)) == text


@pytest.mark.parametrize(
    "url",
    [
        "", "localhost", "http://u:secret@h", "nats://", "nats://u:secret@", "nats://u:secret@h:99999", "nats://u:secret@[::1",
        "nats://u:sec/ret@h", "nats://u:sec?ret@h", "nats://u:sec#ret@h", "nats://h/path",
    ],
)  # fmt: skip
def test_what_is_no_url_is_refused_without_repeating_it(url: str) -> None:
    with pytest.raises(ValueError, match="a NATS URL") as refused:
        read_server(url)
    assert "ret" not in str(refused.value)
