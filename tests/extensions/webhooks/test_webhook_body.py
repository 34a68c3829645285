"""The body of a webhook is what its schema says."""

from contextlib import suppress

from hypothesis import given
from hypothesis import strategies as st

from dock_gateway.core.errors import InvalidField
from dock_gateway.extensions.webhooks.webhook import WebhookBody
from dock_gateway.http.bodies import read_model
from tests.support.bodies import expect_refused

FIELDS = ["name", "url", "robots", "severities", "secret", "enabled", "x"]
JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**53), 2**53) | st.floats(allow_nan=False) | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(FIELDS), inner),
    max_leaves=9,
)


def test_what_the_schema_does_not_allow_is_refused_where_it_is_wrong() -> None:
    expect_refused(WebhookBody)


@given(JSON)
def test_whatever_is_sent_is_read_or_refused(value: object) -> None:
    with suppress(InvalidField):
        read_model(WebhookBody, value)
