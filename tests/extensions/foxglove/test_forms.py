"""Requests and responses of services as viewers write and read them."""

import random

import pytest
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import String
from std_srvs.srv import SetBool

from action_tutorials_interfaces.action import Fibonacci
from dock_gateway.core.errors import GatewayError, InvalidField, MalformedRequest
from dock_gateway.extensions.foxglove.forms import MessageForm, ResultForm, TextForm

TEXTS = TextForm("some/srv/Texts", ("first", "second"))


def test_texts_are_as_ros_writes_them() -> None:
    one = TextForm("some/srv/Text", ("data",))
    assert one.schema == "string data"
    for text in ("", "a", "äöü", "longer than four"):
        assert deserialize_message(one.write("cdr", {"data": text}), String).data == text
        assert one.read("cdr", serialize_message(String(data=text))) == ({"data": text} if text else {})


@pytest.mark.parametrize("encoding", ["cdr", "json"])
def test_texts_there_and_back(encoding: str) -> None:
    written = TEXTS.write(encoding, {"first": "abc", "second": "d", "more": "is left out"})
    assert TEXTS.read(encoding, written) == {"first": "abc", "second": "d"}
    assert TEXTS.read(encoding, TEXTS.write(encoding, {"second": "x"})) == {"second": "x"}


def test_texts_of_another_byte_order() -> None:
    assert TEXTS.read("cdr", b"\0\0\0\0\0\0\0\2a\0\0\0\0\0\0\2b\0") == {"first": "a", "second": "b"}


@pytest.mark.parametrize(
    "data", [b"", b"\0\1", b"\0\1\0\0", b"\0\1\0\0\5\0\0\0ab", b"\0\1\0\0\xff\xff\xff\xffab", b"\0\1\0\0\1\0\0\0\xff"]
)
def test_bytes_that_are_no_texts(data: bytes) -> None:
    with pytest.raises(MalformedRequest, match="are no some/srv/Texts in CDR"):
        TEXTS.read("cdr", data)


def test_json_that_is_no_object_and_other_encodings() -> None:
    for form in (TEXTS, MessageForm(SetBool.Request)):
        with pytest.raises(InvalidField, match="one of cdr, json"):
            form.read("protobuf", b"")
        with pytest.raises(MalformedRequest, match="not JSON"):
            form.read("json", b"{")
    with pytest.raises(InvalidField, match="an object"):
        TEXTS.read("json", b"[]")


def test_a_message() -> None:
    form = MessageForm(SetBool.Response)
    assert "string message" in form.schema
    answer = SetBool.Response(success=True, message="on")
    assert form.read("cdr", form.write("cdr", answer)) == answer
    assert form.read("json", form.write("json", answer)) == {"success": True, "message": "on"}


def test_a_result_and_what_became_of_its_goal() -> None:
    form = ResultForm("some/srv/Result", Fibonacci.Result, ("status",))
    own, _, others = form.schema.partition("=" * 80 + "\n")
    assert own.split() == ["action_tutorials_interfaces/Fibonacci_Result", "result", "string", "status"]
    assert others.startswith("MSG: action_tutorials_interfaces/Fibonacci_Result\n")
    data = form.write("cdr", {"result": b'{"sequence": [0, 1]}', "status": "succeeded"})
    assert list(deserialize_message(data, Fibonacci.Result).sequence) == [0, 1]
    assert data.endswith(b"succeeded\0")
    assert form.write("json", {"result": None, "status": "lost"}) == b'{"result":null,"status":"lost"}'
    assert form.write("cdr", {"result": None, "status": "lost"}).endswith(b"\x05\0\0\0lost\0")


def test_any_bytes_are_a_message_or_refused() -> None:
    chance = random.Random(7)
    forms = [MessageForm(each) for each in (Fibonacci.Goal, Fibonacci.Result, SetBool.Response, String)]
    for _ in range(300):
        data = chance.choice([b"", b"\0\1\0\0"]) + chance.randbytes(chance.randrange(40))
        for form in (*forms, TEXTS):
            try:
                form.read("cdr", data)
            except GatewayError as error:
                assert "in CDR" in error.detail  # noqa: PT017
