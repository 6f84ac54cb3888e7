"""Results as a report to read, in plain text."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import singledispatch
from textwrap import fill

import numpy as np
from numpy.typing import NDArray

from core.results import ComponentSampling, CurveGap, Diagnosis, Nyquist, Sampling, Violation

__all__ = ["report"]

_WIDTH = 100
_MOST = 10  # components, or violations, that are told one by one
_METHODS = {"pca": "the PCA march", "skeleton": "the skeleton"}


@singledispatch
def report(result: object) -> str:
    """Return the report on a result; register a function for each new type of result."""
    raise TypeError(f"no report is defined for {type(result).__name__}")


@report.register
def _(result: Diagnosis) -> str:
    """Tell the verdict first, then what is wrong, then the figures."""
    parts = [
        fill(result.verdict, _WIDTH),
        *_violations(result.sampling.nyquist.violations),
        *_figures(_rows(result)),
        *_components(result.sampling.components),
        *_remarks(result),
    ]
    return "\n\n".join(parts) + "\n"


def _violations(violations: tuple[Violation, ...]) -> Iterator[str]:
    told = [_item(_sentence(one.reason), _sentence(one.advice)) for one in violations[:_MOST]]
    if len(violations) > _MOST:
        told.append(f"- and {len(violations) - _MOST} more")
    if told:
        yield "\n".join(["What is wrong:", *told])


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:].rstrip('.')}." if text else ""


def _item(*sentences: str) -> str:
    text = " ".join(sentence for sentence in sentences if sentence)
    return fill(text, _WIDTH, initial_indent="- ", subsequent_indent="  ")


def _rows(result: Diagnosis) -> Iterator[tuple[str, str]]:
    """Name each figure, and say what it is."""
    sampling = result.sampling
    opened = result.curves - result.closed
    yield "method", f"{_METHODS[result.method]}. {result.reason}"
    crossings = "1 crossing" if result.crossings == 1 else f"{result.crossings} crossings"
    yield "curves", f"{result.closed} closed, {opened} open, {crossings}"
    yield "noise", _sigma(sampling)
    yield "density", f"{_number(sampling.density)} samples per unit of length"
    yield "epsilon", f"{_number(sampling.epsilon)}, the largest hop between neighbours"
    yield "nearest branches", _margin(sampling.nyquist)
    if sampling.largest_gap is not None:
        yield "longest gap", _gap(sampling.largest_gap)
    yield "outliers", f"{len(result.outliers)}"


def _sigma(sampling: Sampling) -> str:
    error = "" if sampling.sigma_error is None else f" ± {_number(sampling.sigma_error)}"
    text = f"sigma {_number(sampling.sigma)}{error}"
    for along in sampling.sigma_along:
        low, high = np.min(along.sigma), np.max(along.sigma)
        text += f"; along curve {along.curve} from {_number(low)} to {_number(high)}"
    return text


def _margin(nyquist: Nyquist) -> str:
    if nyquist.margin_sigmas is None:
        return "none come near each other"
    place = "" if nyquist.margin_location is None else f", near {_place(nyquist.margin_location)}"
    return f"{nyquist.margin_sigmas:.1f} sigma apart{place}"


def _gap(gap: CurveGap) -> str:
    return (
        f"{_number(gap.length)}, {gap.spacings:.1f} mean distances between samples (chance alone: up to "
        f"{gap.expected:.1f}), on curve {gap.curve} near {_place(gap.location)}"
    )


def _figures(rows: Iterable[tuple[str, str]]) -> Iterator[str]:
    yield "\n".join(
        fill(text, _WIDTH, initial_indent=f"{name:<18}", subsequent_indent=18 * " ") for name, text in rows
    )


def _components(components: tuple[ComponentSampling, ...]) -> Iterator[str]:
    """Tell of each component, where there are several."""
    if len(components) < 2:
        return
    lines = [f"{'component':>9} {'samples':>8} {'sigma':>10} {'density':>10}"]
    lines += [
        f"{one.label:>9} {one.size:>8} {_number(one.sigma):>10} {_number(one.density):>10}"
        for one in components[:_MOST]
    ]
    if len(components) > _MOST:
        lines.append(f"and {len(components) - _MOST} more")
    yield "\n".join(lines)


def _remarks(result: Diagnosis) -> Iterator[str]:
    told = [_item(warning.message) for warning in result.warnings[:_MOST]]
    if told:
        yield "\n".join(["Warnings:", *told])


def _place(location: NDArray[np.float64]) -> str:
    return f"({', '.join(map(_number, location.tolist()))})"


def _number(value: float) -> str:
    return f"{value:.4g}"
