"""How far a long computation has come, told to whoever wants to know.

Whoever computes tells what it begins to do, and what share of its own work lies behind; whoever called
it knows what share of the whole that work is. Nobody listening costs a comparison with None.
"""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["Progress", "tell", "within"]

Progress = Callable[[float, str], None]
"""Called with the fraction of the work that is done, 0 to 1, and with what is being done now."""


def tell(progress: Progress | None, fraction: float, what: str) -> None:
    """Tell how far a computation has come, where anybody listens.

    Parameters
    ----------
    progress : Progress or None
    fraction : float
        Of the work that is done, 0 to 1.
    what : str
        What is being done now, such as "marching".
    """
    if progress is not None:
        progress(fraction, what)


def within(progress: Progress | None, start: float, end: float, where: str = "") -> Progress | None:
    """The progress of a part of the work, as progress of the whole.

    Parameters
    ----------
    progress : Progress or None
        Of the whole.
    start, end : float
        Fractions of the whole at which the part begins and ends.
    where : str
        Put before what the part tells, such as "component 3 of 12: ".

    Returns
    -------
    Progress or None
        None where nobody listens.

    Notes
    -----
    A part that is done is exactly at ``end``, and rounding leads nowhere beyond it: where a part tells
    ascending fractions and the next one begins at its end, the fractions of the whole ascend.

    Examples
    --------
    >>> half = within(lambda fraction, what: print(f"{fraction:.0%} {what}"), 0.5, 1.0, "last half: ")
    >>> tell(half, 0.5, "tidying up")
    75% last half: tidying up
    """
    if progress is None:
        return None

    def told(fraction: float, what: str) -> None:
        progress(end if fraction >= 1.0 else min(start + fraction * (end - start), end), where + what)

    return told
