"""Where computing happens: a pool of warm processes, each killable, none of them the web process."""

from __future__ import annotations

from service.work.body import Body, receive
from service.work.pool import Pool, PoolOptions, open_pool

__all__ = ["Body", "Pool", "PoolOptions", "open_pool", "receive"]
