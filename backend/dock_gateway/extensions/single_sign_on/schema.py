"""The shapes of what the API says of people of the identity provider."""

from datetime import datetime

from dock_gateway.access.schema import Grant
from dock_gateway.http.schema import Schema


class Person(Grant):
    """A person who is logged in with the identity provider. `subject` is the provider's id of them."""

    name: str
    subject: str
    sessions: int
    logged_in_at: datetime
    expires_at: datetime


class PersonList(Schema):
    """The people, by name."""

    people: list[Person]
