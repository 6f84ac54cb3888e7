"""Where inputs and results of jobs lie, and how results become files."""

from __future__ import annotations

from service.store.files import Entry, Store
from service.store.frozen import freeze, thaw

__all__ = ["Entry", "Store", "freeze", "thaw"]
