"""The peers' own environment, in a folder that git ignores: packages, and a program with CGAL."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import sys
from pathlib import Path

__all__ = ["FOLDER", "ROOT", "build_transport", "has_auto", "make_environment", "versions"]

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
FOLDER = ROOT / "build" / "peers"
LOCK = HERE / "requirements.lock"
SOURCE = HERE / "transport.cpp"
HEADERS = Path("CGAL") / "Optimal_transportation_reconstruction_2.h"
DEBIAN = ("libcgal-dev", "libgmp-dev", "libmpfr-dev")

_VERSIONS = (
    "import importlib.metadata as m, json, sys; "
    "print(json.dumps({n: m.version(n) for n in sys.argv[1:]} | {'Python': sys.version.split()[0]}))"
)


def make_environment(folder: Path = FOLDER, lock: Path = LOCK) -> Path:
    """Install the packages of a lock, unless that is done; return the environment's interpreter."""
    python, stamp = folder / "venv" / "bin" / "python", folder / "installed"
    wanted = hashlib.sha256(lock.read_bytes()).hexdigest()
    if stamp.exists() and stamp.read_text() == wanted and python.exists():
        return python
    print(f"Installing the peers into {folder} (minutes, the first time)", file=sys.stderr)
    _run(sys.executable, "-m", "venv", "--clear", str(folder / "venv"))
    install = ("install", "--quiet", "--disable-pip-version-check", "--require-hashes", "-r", str(lock))
    _run(str(python), "-m", "pip", *install)
    stamp.write_text(wanted)
    return python


def versions(python: Path, packages: tuple[str, ...]) -> dict[str, str]:
    """Return the versions of packages in an environment, and that of its interpreter."""
    found: dict[str, str] = json.loads(_run(str(python), "-c", _VERSIONS, *packages))
    return found


def build_transport(folder: Path = FOLDER) -> Path | None:
    """Compile the program that uses CGAL; None, and a word of advice, where that cannot be done.

    Headers that the system lacks are downloaded as Debian's packages and unpacked in the folder,
    without being installed.
    """
    program = folder / "transport"
    if program.exists() and program.stat().st_mtime > SOURCE.stat().st_mtime:
        return program
    compiler = shutil.which("c++")
    if compiler is None or not (_is_installed() or _unpack_headers(folder)):
        print("CGAL is left out: it needs c++, libcgal-dev and libboost-dev.", file=sys.stderr)
        return None
    places = [] if _is_installed() else _places(folder / "root" / "usr")
    options = ("-O2", "-std=c++17", "-DNDEBUG", "-DCGAL_NDEBUG", "-w", *places)
    _run(compiler, *options, str(SOURCE), "-o", str(program), "-lgmp", "-lmpfr")
    return program


def _is_installed() -> bool:
    return all((Path("/usr/include") / one).exists() for one in (HEADERS, "boost/version.hpp", "gmpxx.h"))


def _places(usr: Path) -> list[str]:
    """Compiler options for headers and libraries under an unpacked /usr."""
    inside = [usr / "include", *(usr / "include").glob("*-linux-gnu")]
    libraries = [place for place in (usr / "lib").glob("*-linux-gnu") if place.is_dir()]
    return [*(f"-I{one}" for one in inside), *(f"-L{one}" for one in libraries)]


def _unpack_headers(folder: Path) -> bool:
    """Download Debian's packages and unpack them; False where there is no apt or no such package."""
    if shutil.which("apt-get") is None or shutil.which("dpkg-deb") is None:
        return False
    target = folder / "debian"
    target.mkdir(parents=True, exist_ok=True)
    try:
        listed = _run("apt-cache", "depends", "libboost-dev").split()
        boost = [one for one in listed if one.startswith("libboost") and one != "libboost-dev"]
        _run("apt-get", "download", *DEBIAN, *boost[:1], folder=target)
    except subprocess.CalledProcessError:
        return False
    for package in target.glob("*.deb"):
        _run("dpkg-deb", "-x", str(package), str(folder / "root"))
    return True


def _run(*command: str, folder: Path | None = None) -> str:
    done = subprocess.run(command, check=True, cwd=folder, stdout=subprocess.PIPE, text=True)  # noqa: S603 - our own
    return done.stdout


def has_auto() -> bool:
    """Tell whether this checkout has the method that chooses by itself."""
    from core import methods  # noqa: PLC0415 - compiled kernels come with it

    return hasattr(methods, "reconstruct")
