"""Draw all pictures, or those named: ``python -m benchmarks.figures [name ...]``."""

from __future__ import annotations

import argparse

from benchmarks.figures.gallery import gallery
from benchmarks.figures.growth import figure_12
from benchmarks.figures.marches import figure_3, figure_6
from benchmarks.figures.overview import overview
from benchmarks.figures.skeletons import figure_5, figure_10, figure_11
from benchmarks.figures.surfaces import figure_7, figure_8, figure_9, solids, way

PICTURES = {
    "3": figure_3,
    "5": figure_5,
    "6": figure_6,
    "7": figure_7,
    "8": figure_8,
    "9": figure_9,
    "10": figure_10,
    "11": figure_11,
    "12": figure_12,
    "way": way,
    "solids": solids,
    "overview": overview,
    "gallery": gallery,
}


def main() -> None:
    """Draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="name", help="the paper's number, or a name")
    for name in parser.parse_args().names or PICTURES:
        PICTURES[name]()


if __name__ == "__main__":
    main()
