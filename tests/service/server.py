"""Serve the test process, and the real ones when asked to, on the port of the settings."""

from __future__ import annotations

import sys

import uvicorn
from rows import TRIAL

from service.app import create_app
from service.processes import PROCESSES
from service.settings import Settings

if __name__ == "__main__":
    settings = Settings()
    table = (TRIAL, *PROCESSES) if sys.argv[1:] == ["all"] else (TRIAL,)
    uvicorn.run(
        create_app(settings, table), host=settings.host, port=settings.port, log_level="warning", ws="none"
    )
