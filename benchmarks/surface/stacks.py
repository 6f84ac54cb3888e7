"""Random stacks of contours, as hard on the surface as can be, and whether each is a closed manifold."""

from __future__ import annotations

import sys
import time

import numpy as np

from benchmarks.surface.rows import StackRow
from core.errors import DegenerateInput
from core.surface.mesh_report import is_sound
from core.surface.skin import surface_of
from core.truth.stacks import random_stack

__all__ = ["span_stacks"]

SHOWN = 1000  # stacks after which a word is said


def span_stacks(count: int) -> StackRow:
    """Span the stacks of the seeds 0, 1, ..."""
    surface_of(random_stack(0))  # compiles the kernels
    seconds, wrong = [], []
    sound = fallbacks = empty = failures = 0
    for seed in range(count):
        began = time.process_time()
        try:
            report = surface_of(random_stack(seed)).report
        except DegenerateInput:  # nothing is enclosed: rightly refused
            empty += 1
            continue
        except Exception as error:  # whatever it raises is a failure
            print(f"stack {seed}: {type(error).__name__}: {error}", file=sys.stderr)
            failures += 1
            wrong.append(seed)
            continue
        seconds.append(time.process_time() - began)
        fallbacks += report.method != "slabs"
        if is_sound(report):
            sound += 1
        else:
            wrong.append(seed)
        if seed % SHOWN == SHOWN - 1:
            print(f"{seed + 1} stacks, {sound} sound, {fallbacks} by distances", file=sys.stderr)
    times = np.array(seconds or [0.0])
    return StackRow(
        count, sound, fallbacks, empty, failures, float(np.median(times)), float(times.max()), tuple(wrong)
    )
