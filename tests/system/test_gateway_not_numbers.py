"""NaN and Infinity as Python's `json` writes them: a sentence says what to send."""

import orjson
import pytest

from tests.support.clients import connect
from tests.support.gateway import RunningGateway
from tests.support.waiting import PATIENCE

pytestmark = pytest.mark.ros

SAYS = "send null instead of NaN; infinite numbers are not accepted"


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity"])
def test_what_to_send(gateway: RunningGateway, number: str) -> None:
    body = f'{{"voltage": {number}}}'.encode()
    refused = gateway.http.post("/battery", content=body, headers={"Content-Type": "application/json"})
    assert (refused.status_code, refused.json()["code"]) == (400, "malformed_json")
    assert SAYS in refused.json()["detail"]
    with connect(f"{gateway.url.replace('http', 'ws')}/ws") as socket:
        socket.send(f'{{"op": "publish_battery", "id": "1", "state": {body.decode()}}}')
        error = orjson.loads(socket.recv(PATIENCE))
        assert (error["op"], error["error"]["code"]) == ("error", "malformed_json")
        assert SAYS in error["error"]["detail"]
