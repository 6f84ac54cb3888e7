"""Which workers live: each answers the roll in the database, on the database's own clock.

The engine takes up what a worker of the same name left when it starts again;
what a worker left that never comes back, the others take up.
"""

from __future__ import annotations

from contextlib import suppress

import sqlalchemy as sa
from dbos import DBOS

__all__ = ["BEAT_SECONDS", "LAPSE_SECONDS", "Roll"]

BEAT_SECONDS = 1.0
LAPSE_SECONDS = 5.0
"""A worker that has not answered for so long is dead to the others: its jobs are theirs."""

_SCHEMA = sa.MetaData()
_TABLE = sa.Table(
    "tapeline_workers",
    _SCHEMA,
    sa.Column("id", sa.Text, primary_key=True),
    sa.Column("seen", sa.BigInteger, nullable=False),  # milliseconds
)
_DUTIES = sa.Table(
    "tapeline_duties",
    _SCHEMA,
    sa.Column("id", sa.Text, primary_key=True),
    sa.Column("done", sa.BigInteger, nullable=False),  # milliseconds
)
_NOW = {
    "sqlite": "CAST((julianday('now') - 2440587.5) * 86400000 AS INTEGER)",
    "postgresql": "CAST(EXTRACT(EPOCH FROM clock_timestamp()) * 1000 AS BIGINT)",
}


class Roll:
    """The table of workers that live.

    Parameters
    ----------
    url : str
        The database.
    worker : str
        Our own name.
    """

    def __init__(self, url: str, worker: str) -> None:
        address = sa.make_url(url)
        if address.get_backend_name() == "postgresql":
            address = address.set(drivername="postgresql+psycopg")
        self._engine = sa.create_engine(address, pool_size=1, pool_pre_ping=True)
        self._now: sa.ColumnElement[int] = sa.literal_column(_NOW[address.get_backend_name()])
        self._worker = worker
        with suppress(sa.exc.DBAPIError), self._engine.begin() as connection:
            _SCHEMA.create_all(connection)  # another worker may be doing the same

    def answer(self) -> None:
        """Say that we live."""
        with self._engine.begin() as connection:
            mine = _TABLE.c.id == self._worker
            if not connection.execute(sa.update(_TABLE).where(mine).values(seen=self._now)).rowcount:
                connection.execute(sa.insert(_TABLE).values(id=self._worker, seen=self._now))

    def take_up(self) -> list[str]:
        """Give the jobs of workers that are dead back to the queue, and strike the dead off the roll."""
        dead = self._dead()
        if dead:
            DBOS._recover_pending_workflows(dead)  # moves only what is still theirs: all of us may try
            self._strike(dead)
        return dead

    def leave(self) -> None:
        """Say that we live no more, so that others take up our jobs at once."""
        with self._engine.begin() as connection:
            connection.execute(sa.update(_TABLE).where(_TABLE.c.id == self._worker).values(seen=0))

    def takes_duty(self, duty: str, seconds: float) -> bool:
        """Whether it is for us to do what one of all workers does every so many seconds."""
        with self._engine.begin() as connection:
            due = sa.update(_DUTIES).where(
                _DUTIES.c.id == duty, _DUTIES.c.done < self._now - int(1000 * seconds)
            )
            if connection.execute(due.values(done=self._now)).rowcount:
                return True
            known = connection.execute(sa.select(_DUTIES.c.id).where(_DUTIES.c.id == duty)).first()
        if known is None:
            with suppress(sa.exc.IntegrityError), self._engine.begin() as connection:
                connection.execute(sa.insert(_DUTIES).values(id=duty, done=0))
        return False

    def names(self) -> set[str]:
        """All workers on the roll, also those that have not answered for a while."""
        with self._engine.begin() as connection:
            return {str(name) for name in connection.execute(sa.select(_TABLE.c.id)).scalars()}

    def _dead(self) -> list[str]:
        lapsed = _TABLE.c.seen < self._now - int(1000 * LAPSE_SECONDS)
        with self._engine.begin() as connection:
            found = connection.execute(sa.select(_TABLE.c.id).where(lapsed)).scalars()
            return [str(name) for name in found if name != self._worker]

    def _strike(self, names: list[str]) -> None:
        with self._engine.begin() as connection:
            connection.execute(sa.delete(_TABLE).where(_TABLE.c.id.in_(names)))
