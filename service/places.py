"""Where the processes of the service keep what they need between runs."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import core

__all__ = ["caches", "home"]


@contextmanager
def home(data_dir: Path) -> Iterator[Path]:
    """Give the data directory or, when it cannot be written, a temporary one for the time of the block."""
    if _writable(data_dir):
        yield data_dir.absolute()
        return
    with tempfile.TemporaryDirectory(prefix="tapeline-") as spare:
        yield Path(spare)


def caches(place: Path) -> dict[str, str]:
    """Say by environment variables where compiled kernels and font lists are kept.

    Kernels stay beside their source, where tests and the command line find
    them too, unless the installation is read-only.
    """
    places = {"MPLCONFIGDIR": place / "matplotlib"}
    if not os.access(Path(core.__file__).parent, os.W_OK):
        places["NUMBA_CACHE_DIR"] = place / "numba"
    return {name: os.environ.get(name, str(path)) for name, path in places.items()}


def _writable(directory: Path) -> bool:
    try:
        directory.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=directory):
            return True
    except OSError:
        return False
