"""The first messages between a site and its hub: hello, welcome, refusal."""

import re
from typing import Annotated, TypeVar
from uuid import UUID

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from dock_gateway.sites.subjects import ID_PATTERN

# Bytes of a hello, a welcome or a refusal.
MAX_BYTES = 8192
# Characters about what is not valid in a message.
MAX_DETAIL = 200
# Minor releases that a site and its hub may be apart.
MAX_MINORS_APART = 1

_VERSION = re.compile(r"(\d+)\.(\d+)(?:\D.*)?")
Seconds = Annotated[float, Field(allow_inf_nan=False)]
Version = Annotated[str, Field(min_length=1, max_length=64)]
# A public key of a `KeyAgreement`; empty: none.
PublicKey = Annotated[str, Field(max_length=64)]


class Malformed(ValueError):
    """A message cannot be read.

    Args:
        reason: A stable name, for the counters: `malformed` or `too_large`.
        detail: A human-readable sentence.
    """

    def __init__(self, reason: str, detail: str) -> None:
        super().__init__(detail)
        self.reason = reason
        self.detail = detail


class _Message(BaseModel):
    # Another release may say more.
    model_config = ConfigDict(frozen=True, extra="ignore")

    def encode(self) -> bytes:
        """Return the message as JSON."""
        return self.model_dump_json().encode()


class Hello(_Message):
    """A site asks whether it is welcome, and says that it is still there.

    Attributes:
        installation: Made once, and kept in the site's history.
        instance: The process: 16 hexadecimal digits.
        version: The gateway's release.
        at: The site's clock, in seconds since 1970.
        leaving: The process ends now.
        name_of_machine: For people.
        public: The public key of this process, for seals.
        agreed: The public key of the hub that it has agreed with.
    """

    installation: UUID
    instance: Annotated[str, Field(pattern=ID_PATTERN)]
    version: Version
    at: Seconds
    leaving: bool = False
    name_of_machine: Annotated[str, Field(max_length=253)] = ""
    public: PublicKey = ""
    agreed: PublicKey = ""


class Welcome(_Message):
    """The hub takes a site.

    Attributes:
        hub_version: The hub's release.
        at: The hub's clock, in seconds since 1970.
        public: The public key of this process of the hub, for seals.
        proof: Signed by the hub: its public key and that of the site. Empty if the site has agreed with it already.
    """

    ok: bool = True
    hub_version: Version
    at: Seconds
    public: PublicKey = ""
    proof: Annotated[str, Field(max_length=4000)] = ""


class Refusal(_Message):
    """Something is refused.

    Attributes:
        code: A stable name, such as `site_name_taken`.
        detail: A sentence for people.
        status: The HTTP status that this stands for.
    """

    ok: bool = False
    code: Annotated[str, Field(min_length=1, max_length=64)]
    detail: Annotated[str, Field(max_length=8000)] = ""
    status: Annotated[int, Field(ge=400, le=599)] = 503


M = TypeVar("M", bound=_Message)


def read(model: type[M], data: bytes) -> M:
    """Read a message.

    Raises:
        Malformed: It is too long, or not such a message.
    """
    if len(data) > MAX_BYTES:
        raise Malformed("too_large", f"a message of {len(data)} bytes; at most {MAX_BYTES} are read")
    try:
        return model.model_validate_json(data)
    except ValidationError as error:
        raise malformed(error) from None


def malformed(error: ValidationError) -> Malformed:
    """Return the first thing that is not valid."""
    first = error.errors(include_url=False, include_context=False, include_input=False)[0]
    place = ".".join(map(str, first["loc"])) or "message"
    return Malformed("malformed", f"{place}: {first['msg']}"[:MAX_DETAIL])


class _Answer(_Message):
    ok: bool


def read_answer(data: bytes) -> Welcome | Refusal:
    """Read the answer to a hello.

    Raises:
        Malformed: It is neither a welcome nor a refusal.
    """
    return read_refusal(data) or read(Welcome, data)


def read_refusal(data: bytes) -> Refusal | None:
    """Read an answer that may be a refusal; None if it is not.

    Raises:
        Malformed: It is no answer.
    """
    return None if read(_Answer, data).ok else read(Refusal, data)


def compatible(one: str, other: str) -> bool:
    """Return whether two releases work together: at most one minor release apart."""
    first, second = _VERSION.fullmatch(one), _VERSION.fullmatch(other)
    if first is None or second is None:
        return False
    return first[1] == second[1] and abs(int(first[2]) - int(second[2])) <= MAX_MINORS_APART
