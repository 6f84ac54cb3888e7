"""``python -m service.jobs TABLE``: the worker that a web process keeps beside it."""

from __future__ import annotations

import sys

from service.jobs.keeper import compute_beside

if __name__ == "__main__":
    compute_beside(sys.argv[1])
