"""Open3D's own environment, in a folder that git ignores."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from benchmarks.peers import environment

__all__ = ["FOLDER", "LOCK", "is_usable", "make_environment"]

FOLDER = environment.ROOT / "build" / "surface"
LOCK = Path(__file__).parent / "requirements.lock"


def make_environment(folder: Path = FOLDER) -> Path:
    """Install Open3D, unless that is done; return the environment's interpreter."""
    return environment.make_environment(folder, LOCK)


def is_usable(python: Path) -> bool:
    """Tell whether Open3D can be imported; a word of advice where it cannot."""
    done = subprocess.run([str(python), "-c", "import open3d"], capture_output=True, text=True, check=False)  # noqa: S603 - our own
    if done.returncode:
        print(done.stderr.strip().splitlines()[-1:], file=sys.stderr)
        print("Open3D is left out: it needs the system's libusb-1.0-0 and libgl1.", file=sys.stderr)
    return done.returncode == 0
