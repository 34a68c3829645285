"""Subjects are read as they are built, and nothing else is."""

import pytest

from dock_gateway.sites import subjects

ID = "0123456789abcdef"


@pytest.mark.parametrize("name", ["berlin", "a", "oslo_2", "x" * 40])
def test_names_of_sites(name: str) -> None:
    assert subjects.is_site_name(name)


@pytest.mark.parametrize(
    "name", ["", "hub", "Berlin", "2nd", "_a", "a.b", "a*", ">", "x" * 41, "berlin\n", "öl", "a b"]
)
def test_what_is_no_name(name: str) -> None:
    assert not subjects.is_site_name(name)


def test_what_is_built_is_read() -> None:
    stream = subjects.new_id()
    assert subjects.read_hello(subjects.hello("berlin")) == "berlin"
    assert subjects.read_stream_to_hub(subjects.stream_to_hub("berlin", stream)) == ("berlin", stream)
    assert subjects.read_stream_to_site(subjects.stream_to_site("berlin", ID, stream)) == stream
    assert subjects.read_stream_to_site(subjects.open_stream("berlin", ID)) is None


@pytest.mark.parametrize("subject", ["", "dock", "dock.hub.hello.Berlin", "dock.hub.hello.a.b", "dock.hub.hello.hub"])
def test_other_subjects_are_not_read(subject: str) -> None:
    assert subjects.read_hello(subject) is None
    assert subjects.read_stream_to_hub(subject) is None
    assert subjects.read_stream_to_site(subject) is None


@pytest.mark.parametrize("stream", ["", "x", ID[:-1], ID + "0", ID.upper(), "*"])
def test_a_stream_has_16_hexadecimal_digits(stream: str) -> None:
    assert subjects.read_stream_to_hub(f"dock.hub.stream.berlin.{stream}") is None
    assert subjects.read_stream_to_site(f"dock.site.berlin.{ID}.stream.{stream}") is None
