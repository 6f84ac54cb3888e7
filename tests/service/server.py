"""Serve the test process, and the real ones when asked to, on the port of the settings."""

from __future__ import annotations

import sys

import uvicorn

from service.app import create_app
from service.settings import Settings

if __name__ == "__main__":
    settings = Settings()
    table = "rows:ALL" if sys.argv[1:] == ["all"] else "rows:ALONE"
    uvicorn.run(
        create_app(settings, table), host=settings.host, port=settings.port, log_level="warning", ws="none"
    )
