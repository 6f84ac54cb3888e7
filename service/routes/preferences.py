"""What a client prefers: the answer at once, or after a while, or a job (RFC 7240)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

__all__ = ["Preferences"]


@dataclass(frozen=True, slots=True)
class Preferences:
    """The preferences that we know; others, and what cannot be read, are passed over.

    Attributes
    ----------
    asynchronous : bool
        ``respond-async``.
    wait : float or None
        ``wait``, in seconds.
    """

    asynchronous: bool = False
    wait: float | None = None

    @classmethod
    def read(cls, headers: Iterable[str]) -> Preferences:
        """Read the ``Prefer`` headers of a request; of one preference given twice, the first counts."""
        found: dict[str, str] = {}
        for preference in ",".join(headers).split(","):
            name, _, value = preference.split(";")[0].partition("=")
            found.setdefault(name.strip().lower(), value.strip().strip('"'))
        wait = found.get("wait", "")
        return cls("respond-async" in found, float(wait) if wait.isdecimal() and len(wait) < 10 else None)

    def seconds(self, usual: float, most: float) -> float:
        """Say how long to wait for the answer before the client is told where the job is."""
        if self.wait is not None:
            return min(self.wait, most)
        return 0.0 if self.asynchronous else min(usual, most)

    @property
    def applied(self) -> str | None:
        """The value of ``Preference-Applied``."""
        names = ["respond-async"] if self.asynchronous else []
        names += [] if self.wait is None else [f"wait={self.wait:g}"]
        return ", ".join(names) or None
