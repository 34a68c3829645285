"""Runs the migrations on the connection that it is given."""

from alembic import context

from dock_gateway.storage.tables import metadata

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=metadata,
    transactional_ddl=True,  # SQLite's too: all of a migration, or nothing
)
with context.begin_transaction():
    context.run_migrations()
