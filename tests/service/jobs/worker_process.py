"""Compute the test process's jobs, under the name given, like a machine that serves nobody itself."""

from __future__ import annotations

import sys

if __name__ == "__main__":  # the processes of its computations import this module too
    from service.jobs.keeper import leave
    from service.jobs.worker import JobWorker
    from service.logs import configure
    from service.settings import Settings

    settings = Settings()
    configure(settings.log_level)
    JobWorker(settings, "rows:ALONE", sys.argv[1]).run()
    leave()
