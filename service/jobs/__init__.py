"""Long work: durable jobs, computed by processes that can be ended, here or on other machines."""

from __future__ import annotations

from service.jobs.jobs import Jobs, Page
from service.jobs.keeper import TABLE, keep
from service.jobs.order import STATES, Job, Order, State
from service.jobs.sieve import Sieve, sifted
from service.jobs.watch import Watch

__all__ = ["STATES", "TABLE", "Job", "Jobs", "Order", "Page", "Sieve", "State", "Watch", "keep", "sifted"]
