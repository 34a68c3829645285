"""Places over HTTP: stored, listed, changed by version and removed."""

from collections.abc import Iterator
from typing import Any

import pytest

from dock_gateway.extensions.missions.places.place import PlaceEntry
from dock_gateway.extensions.missions.places.places import Places
from dock_gateway.storage.shared_entries import SharedBook
from tests.support.history import HistoryInMemory
from tests.support.route_client import RouteClient

SHELF = {"x": 4.2, "y": 1.5}


class Client(RouteClient):
    """`/places` of a gateway that keeps two of them at most."""

    def __init__(self) -> None:
        places = Places(SharedBook(HistoryInMemory().documents("place", PlaceEntry), "place", 2))
        super().__init__({Places: places})

    def one(self, method: str, place_id: str, status: int = 200, **more: Any) -> Any:
        return self.send(method, f"/places/{place_id}", status, template="/places/{place_id}", **more)


@pytest.fixture
def client() -> Iterator[Client]:
    with Client() as client:
        yield client


def test_a_place_is_stored_changed_and_removed(client: Client) -> None:
    answer = client.http.put("/places/shelf", json=SHELF | {"by": "Ada"})
    assert (answer.status_code, answer.headers["location"]) == (201, "/places/shelf")
    place = answer.json()
    assert (place["id"], place["frame"], place["yaw"], place["name"]) == ("shelf", "map", 0, None)
    assert place["changed_by"] == "Ada"
    assert answer.headers["etag"] == place["etag"]
    assert client.one("GET", "shelf") == place
    changed = client.one(
        "PUT", "shelf", json=SHELF | {"name": " Shelf A3 ", "yaw": 1.57}, headers={"If-Match": place["etag"]}
    )
    assert changed["name"] == "Shelf A3"
    late = client.one("PUT", "shelf", 412, json=SHELF, headers={"If-Match": place["etag"]})
    assert late["code"] == "changed_meanwhile"
    client.one("PUT", "desk", 201, json=SHELF)
    assert [each["id"] for each in client.send("GET", "/places")["places"]] == ["desk", "shelf"]
    full = client.one("PUT", "hall", 409, json=SHELF)
    assert (full["code"], full["limit"]) == ("limit_reached", 2)
    client.one("DELETE", "shelf", 412, headers={"If-Match": place["etag"]})
    for _ in range(2):
        client.one("DELETE", "shelf", 204)
    assert client.one("GET", "shelf", 404)["code"] == "place_not_found"


@pytest.mark.parametrize(
    ("body", "path"),
    [
        ({"x": 1}, "y"),
        ({"x": "1", "y": 2}, "x"),
        ({"x": 1, "y": 1e9}, "y"),
        ({"x": 1, "y": 2, "yaw": 90}, "yaw"),
        ({"x": 1, "y": 2, "frame": ""}, "frame"),
        ({"x": 1, "y": 2, "name": "\n"}, "name"),
        ({"x": 1, "y": 2, "z": 3}, "z"),
    ],
)
def test_what_is_no_place(client: Client, body: Any, path: str) -> None:
    assert client.one("PUT", "shelf", 422, json=body)["errors"][0]["path"] == path
    assert client.send("GET", "/places")["places"] == []


def test_what_is_no_id(client: Client) -> None:
    assert client.one("PUT", "Shelf", 422, json=SHELF)["errors"][0]["path"] == "place_id"
