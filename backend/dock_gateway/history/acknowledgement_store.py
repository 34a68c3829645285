"""Acknowledgements of alerts in a database that several gateways may share."""

import asyncio

import sqlalchemy as sa

from dock_gateway.core.errors import Unavailable
from dock_gateway.history.database import DATABASE_ERRORS, Database
from dock_gateway.history.protocol import Acknowledgement
from dock_gateway.history.queries import insert_into
from dock_gateway.history.reader import AWAY, Reader
from dock_gateway.history.tables import acknowledgements
from dock_gateway.history.writer import Writer

ACKNOWLEDGE_TIMEOUT = 1.0  # seconds


class SqlAcknowledgements:
    """The table of acknowledgements."""

    def __init__(self, database: Database, reader: Reader, writer: Writer) -> None:
        self._database = database
        self._reader = reader
        self._writer = writer

    async def read(self) -> dict[str, Acknowledgement]:
        """Return all acknowledgements, by alert id.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """
        return await self._reader.read(_read)

    async def write(self, alert_id: str, acknowledgement: Acknowledgement | None) -> None:
        """Store the acknowledgement of an alert, replacing the earlier one; None deletes it.

        Raises:
            Unavailable: The database does not answer (`history_unavailable`).
        """
        if not self._database.prepared:
            raise Unavailable(AWAY, code="history_unavailable")
        try:
            async with asyncio.timeout(ACKNOWLEDGE_TIMEOUT):
                await self._database.write(_write, alert_id, acknowledgement)
        except DATABASE_ERRORS as error:
            self._writer.doubt(error)
            raise Unavailable(AWAY, code="history_unavailable") from error


def _read(connection: sa.Connection) -> dict[str, Acknowledgement]:
    rows = connection.execute(sa.select(acknowledgements)).mappings()
    return {row["alert_id"]: Acknowledgement(row["name"], row["acknowledged_at"]) for row in rows}


def _write(connection: sa.Connection, alert_id: str, acknowledgement: Acknowledgement | None) -> None:
    if acknowledgement is None:
        connection.execute(sa.delete(acknowledgements).where(acknowledgements.c.alert_id == alert_id))
        return
    row = {"alert_id": alert_id, "name": acknowledgement.by, "acknowledged_at": acknowledgement.at}
    statement = insert_into(connection, acknowledgements).on_conflict_do_update(index_elements=["alert_id"], set_=row)
    connection.execute(statement, row)
