"""Where inputs and results of jobs lie: files under an fsspec URL, shared by all machines or local.

Names are ours alone, never a client's. What is in the store is whole: a file
appears under its name when all of it is there.
"""

from __future__ import annotations

import shutil
import tempfile
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import fsspec
from fsspec.implementations.local import LocalFileSystem

__all__ = ["Entry", "Store"]

_CHUNK = 1024 * 1024


@dataclass(frozen=True, slots=True)
class Entry:
    """All that lies in one folder of the store: bytes in all, and when the last of it was written."""

    folder: str
    size: int
    modified: float


class Store:
    """Files by name.

    Parameters
    ----------
    url : str
        Any that fsspec reads, such as ``file:///var/lib/tapeline/store`` or
        ``s3://bucket/folder``; the package that knows its kind must be installed.
    """

    def __init__(self, url: str) -> None:
        self._files, self._root = fsspec.core.url_to_fs(url)
        self._local = isinstance(self._files, LocalFileSystem)
        self._files.makedirs(self._root, exist_ok=True)
        staging = Path(self._root, "staging") if self._local else Path(tempfile.gettempdir())
        staging.mkdir(parents=True, exist_ok=True)
        self.staging = staging
        """A local directory for files on their way into the store."""

    def _path(self, name: str) -> str:
        return f"{self._root}/{name}"

    def write(self, name: str, content: bytes) -> None:
        """Write a file, in place of what may have been there."""
        if not self._local:  # object stores show an object when it is complete
            self._files.pipe_file(self._path(name), content)
            return
        part = self.staging / uuid.uuid4().hex
        part.write_bytes(content)
        self.take(name, part)

    def take(self, name: str, file: Path) -> None:
        """Move a local file, best one in ``staging``, into the store."""
        if self._local:
            target = Path(self._path(name))
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.move(file, target)
        else:
            self._files.put_file(str(file), self._path(name))
            file.unlink()

    def read(self, name: str) -> bytes:
        """Return a file's content.

        Raises
        ------
        FileNotFoundError
        """
        content: bytes = self._files.cat_file(self._path(name))
        return content

    def chunks(self, name: str) -> tuple[int, Iterator[bytes]]:
        """Return a file's size in bytes, and its content piece by piece.

        Raises
        ------
        FileNotFoundError
        """
        file = self._files.open(self._path(name), "rb")
        return int(self._files.size(self._path(name))), _pieces(file)

    @contextmanager
    def local(self, name: str) -> Iterator[Path]:
        """Give a file as one on this machine, for the time of the block.

        Raises
        ------
        FileNotFoundError
        """
        if self._local:
            yield Path(self._path(name))
            return
        copy = self.staging / f"tapeline-{uuid.uuid4().hex}"
        self._files.get_file(self._path(name), str(copy))
        try:
            yield copy
        finally:
            copy.unlink(missing_ok=True)

    def has(self, name: str) -> bool:
        """Whether there is such a file."""
        return bool(self._files.isfile(self._path(name)))

    def remove(self, name: str) -> None:
        """Remove a file or a folder with all that is in it, if it is there."""
        with suppress(FileNotFoundError):
            self._files.rm(self._path(name), recursive=True)

    def tidy(self, seconds: float) -> None:
        """Remove what was left on its way into the store so many seconds ago, by processes that died."""
        for file in self.staging.glob("*" if self._local else "tapeline-*"):
            with suppress(FileNotFoundError):
                if file.is_file() and time.time() - file.stat().st_mtime > seconds:
                    file.unlink()

    def folders(self, parent: str) -> list[Entry]:
        """List the folders within a folder, with the sizes of what is in them."""
        self._files.invalidate_cache()
        if not self._files.isdir(self._path(parent)):
            return []
        names = [Path(entry).name for entry in self._files.ls(self._path(parent), detail=False)]
        return [self._entry(f"{parent}/{name}") for name in names]

    def _entry(self, folder: str) -> Entry:
        inside = self._files.find(self._path(folder), detail=True).values()
        times = [_modified(one) for one in inside]
        return Entry(folder, sum(int(one["size"]) for one in inside), max(times, default=0.0))


def _pieces(file: fsspec.spec.AbstractBufferedFile) -> Iterator[bytes]:
    with file:
        while piece := file.read(_CHUNK):
            yield piece


def _modified(info: dict[str, object]) -> float:
    """Seconds since 1970; stores differ in how they say it."""
    for name in ("mtime", "LastModified", "last_modified", "updated", "created"):
        value = info.get(name)
        if isinstance(value, int | float):
            return float(value)
        if value is not None and hasattr(value, "timestamp"):
            return float(value.timestamp())
    return 0.0
