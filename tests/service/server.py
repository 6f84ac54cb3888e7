"""Serve the test process, and all or some of the real ones when asked to, on the port of the settings."""

from __future__ import annotations

import sys

import uvicorn

from service.app import create_app
from service.settings import Settings

if __name__ == "__main__":
    settings = Settings()
    table = f"rows:{(sys.argv[1:] or ['alone'])[0].upper()}"
    uvicorn.run(
        create_app(settings, table), host=settings.host, port=settings.port, log_level="warning", ws="none"
    )
