"""Open3D's own environment, in a folder that git ignores."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path

from benchmarks.peers.environment import ROOT

__all__ = ["FOLDER", "LOCK", "is_usable", "make_environment"]

FOLDER = ROOT / "build" / "surface"
LOCK = Path(__file__).parent / "requirements.lock"


def make_environment(folder: Path = FOLDER) -> Path:
    """Install the locked packages, unless that is done; return the environment's interpreter."""
    python, stamp = folder / "venv" / "bin" / "python", folder / "installed"
    wanted = hashlib.sha256(LOCK.read_bytes()).hexdigest()
    if stamp.exists() and stamp.read_text() == wanted and python.exists():
        return python
    print(f"Installing Open3D into {folder} (minutes, the first time)", file=sys.stderr)
    _run(sys.executable, "-m", "venv", "--clear", str(folder / "venv"))
    install = ("install", "--quiet", "--disable-pip-version-check", "--require-hashes", "-r", str(LOCK))
    _run(str(python), "-m", "pip", *install)
    stamp.write_text(wanted)
    return python


def is_usable(python: Path) -> bool:
    """Tell whether Open3D can be imported; a word of advice where it cannot."""
    done = subprocess.run([str(python), "-c", "import open3d"], capture_output=True, text=True, check=False)  # noqa: S603 - our own
    if done.returncode:
        print(done.stderr.strip().splitlines()[-1:], file=sys.stderr)
        print("Open3D is left out: it needs the system's libusb-1.0-0 and libgl1.", file=sys.stderr)
    return done.returncode == 0


def _run(*command: str) -> None:
    subprocess.run(command, check=True)  # noqa: S603 - our own
