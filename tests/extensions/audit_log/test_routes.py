"""What an admin reads of the audit log."""

import asyncio
import csv
import io

import orjson
import pytest

from dock_gateway.core.errors import Unavailable
from dock_gateway.core.grant import Role
from dock_gateway.extensions.audit_log.routes import ROWS
from tests.support import held_back
from tests.support.audit import make_entry
from tests.support.audited_site import Site
from tests.support.shapes import check_answer


@pytest.fixture
def site() -> Site:
    return Site(authentication=True)


def test_where_no_token_is_asked_for_everybody_reads_it() -> None:
    with Site().client() as http:
        assert http.get("/audit").status_code == 200


def test_reading_is_for_admins_and_recorded(site: Site) -> None:
    asyncio.run(site.history.audit.append([make_entry(number, subject="=1+1") for number in range(5)]))
    with site.client(Role.SUPERVISOR) as http:
        assert http.get("/audit").json()["code"] == "role_required"
        assert site.one().what == "list_audit"
    with site.client(Role.ADMIN) as http:
        answer = http.get("/audit", params={"limit": 2, "principal": "ada"})
        check_answer("GET", "/audit", 200, "application/json", answer.content)
        assert [record["sequence"] for record in answer.json()["records"]] == [5, 4]
        assert answer.json()["records"][0]["outcome"] == "done"
        assert site.one().subject == "limit=2&principal=ada"
        second = http.get("/audit", params={"limit": 4, "cursor": answer.json()["next_cursor"]}).json()
        assert ([record["sequence"] for record in second["records"]], second["next_cursor"]) == ([3, 2, 1], None)
        assert http.get("/audit", params={"outcome": "refused"}).json()["records"] == []
        assert http.get("/audit", params={"robot": "/robot1", "what": "dock"}).json()["records"]
        assert http.get("/audit", params={"robot": "/robot1", "what": "undock"}).json()["records"] == []
        for path in ("/audit", "/audit/export"):
            assert http.get(path, params={"robot": "/robto1"}).json()["code"] == "robot_not_found"
        for wrong in ({"outcome": "x"}, {"robot": "a b"}, {"goal_id": "x"}, {"cursor": "0"}, {"who": "x"}):
            assert http.get("/audit", params=wrong).status_code == 422
        site.audit.entries.clear()
        sheet = http.get("/audit/export", params={"format": "csv"})
        head, first, *_ = csv.reader(io.StringIO(sheet.text))
        assert dict(zip(head, first, strict=True))["subject"] == "'=1+1"
        assert dict(zip(head, first, strict=True))["sequence"] == "5"
        document = http.get("/audit/export", params={"until": "2000-01-01T00:00:00Z"})
        assert document.json() == []
        whole = http.get("/audit/export")
        check_answer("GET", "/audit/export", 200, "application/json", whole.content)
        assert len(whole.json()) == 5
        assert [entry.what for entry in site.audit.entries] == ["export_audit"] * 3


def test_a_head_is_allowed_and_recorded_as_its_get(site: Site) -> None:
    with site.client() as http:
        assert http.head("/audit").status_code == 401
        assert site.one().what == "list_audit"
    with site.client(Role.SUPERVISOR) as http:
        assert http.head("/audit/export").status_code == 403
        assert site.one().code == "role_required"
    with site.client(Role.ADMIN) as http:
        for _ in range(5):  # more than one user may have at a time
            response = http.head("/audit/export")
            assert (response.status_code, response.content) == (200, b"")
            assert (site.one().what, response.headers["content-type"]) == ("export_audit", "application/json")


@pytest.mark.parametrize("kind", ["csv", "json"])
def test_an_export_of_a_history_that_is_away_is_refused(site: Site, kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    async def fail(*_: object, **__: object) -> None:
        raise Unavailable("the history database does not answer", code="history_unavailable")

    monkeypatch.setattr(site.history.audit, "page", fail)
    with site.client(Role.ADMIN) as http:
        answer = http.get("/audit/export", params={"format": kind})
    assert (answer.status_code, answer.json()["code"]) == (503, "history_unavailable")


@pytest.mark.parametrize("count", [0, 1, ROWS, 2 * ROWS, 2 * ROWS + 1])
def test_an_export_has_every_record(site: Site, count: int) -> None:
    if count:
        asyncio.run(site.history.audit.append([make_entry(number) for number in range(count)]))
    with site.client(Role.ADMIN) as http:
        head, *rows = csv.reader(io.StringIO(http.get("/audit/export", params={"format": "csv"}).text))
        records = http.get("/audit/export").json()
    assert head[0] == "sequence"
    assert [int(row[0]) for row in rows] == [record["sequence"] for record in records] == [*range(count, 0, -1)]


@pytest.mark.usefixtures("quick_hashes")
async def test_an_export_ends_with_the_login() -> None:
    """Its client cannot take the part for the whole."""
    site = await held_back.Site().open()
    await site.history.audit.append([make_entry(number) for number in range(1200)])
    whole = await site.read("/audit/export")
    assert len(orjson.loads(whole)) == 1200
    part = await site.read("/audit/export", after_a_piece=held_back.log_out)
    assert 0 < len(part) < len(whole)
    with pytest.raises(orjson.JSONDecodeError):
        orjson.loads(part)
