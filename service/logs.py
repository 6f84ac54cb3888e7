"""Where our messages go: where the server's own go, in every process alike."""

from __future__ import annotations

import copy
import logging.config
from typing import Any

from uvicorn.config import LOGGING_CONFIG

__all__ = ["configuration", "configure"]


def configuration(level: str) -> dict[str, Any]:
    """Return the server's configuration of logging, with our own messages in it."""
    config = copy.deepcopy(LOGGING_CONFIG)
    config["loggers"]["service"] = {"handlers": ["default"], "level": level.upper(), "propagate": False}
    return config


def configure(level: str) -> None:
    """Configure a process that is no web server."""
    logging.config.dictConfig(configuration(level))
