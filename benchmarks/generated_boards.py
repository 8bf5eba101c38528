"""Boards of any number of parts, made by rule: the same number gives the same board.

A board is a grid of equal clusters of about 45 parts: a large package with leads or balls, a few small ones, a
connector, and the chips around them, at the density of ``smt-demo``. Its area grows with the number of parts.
"""

from itertools import cycle, islice
from math import ceil, sqrt

import numpy as np
from sample_boards.assemble import Place, Sample, assemble
from sample_boards.catalogue import shape_of
from sample_boards.shapes import rectangle

from boards.board import Body, Side

_MAINS = (
    "LQFP-64_10x10mm_P0.5mm",
    "QFN-48-1EP_7x7mm_P0.5mm",
    "BGA-144_13x13mm_P1.0mm",
    "LQFP-48_7x7mm_P0.5mm",
    "LQFP-100_14x14mm_P0.5mm",
)
"""One to a cluster, in turn."""
_OTHERS = {
    "PinHeader_2x05_P2.54mm_Vertical": 1,
    "SOIC-14_3.9x8.7mm_P1.27mm": 1,
    "CP_Elec_6.3x7.7": 1,
    "TSSOP-16_4.4x5mm_P0.65mm": 1,
    "SOIC-8_3.9x4.9mm_P1.27mm": 2,
    "QFN-32-1EP_5x5mm_P0.5mm": 1,
    "CP_EIA-3216-18_Kemet-A": 2,
    "SOT-23-5": 1,
    "SOT-23": 3,
    "D_MiniMELF": 2,
    "C_0805_2012Metric": 3,
    "R_0805_2012Metric": 2,
    "C_0603_1608Metric": 6,
    "R_0603_1608Metric": 5,
    "C_0402_1005Metric": 7,
    "R_0402_1005Metric": 6,
}
"""Of every cluster."""
_CLUSTER_MM = 45.0
_NEAR_MM, _APART_MM = 0.9, 2.6
"""Gaps between parts that stand together, and from one group to the next."""
_GROUP = 4
_LEVEL_UP = 5
"""So many clusters are turned the same way before the next ones are turned."""


def generated_board(parts: int, *, two_sided: bool = False) -> tuple[Body, ...]:
    """Make the bodies of a board with that many parts; with two sides every second cluster is on the bottom."""
    packages = list(islice(_sequence(), parts))
    clusters = [packages[at : at + _cluster_size()] for at in range(0, parts, _cluster_size())]
    across = ceil(sqrt(1.25 * len(clusters)))
    up = ceil(len(clusters) / across)
    places: list[Place] = []
    for number, names in enumerate(clusters):
        corner = _CLUSTER_MM * (number % across), _CLUSTER_MM * (number // across)
        side: Side = "bottom" if two_sided and number % 2 else "top"
        places += _cluster(names, corner, len(places), 90.0 * (number // _LEVEL_UP % 4), side)
    size = (_CLUSTER_MM * across, _CLUSTER_MM * up)
    outline = rectangle(size, (size[0] / 2, size[1] / 2))
    return assemble(Sample(f"generated-{parts}", outline, (), -1.6, 0.0, tuple(places)))


def _cluster_size() -> int:
    return 1 + sum(_OTHERS.values())


def _sequence():
    """Packages, cluster after cluster, without end."""
    for main in cycle(_MAINS):
        yield main
        for package, count in _OTHERS.items():
            yield from [package] * count


def _cluster(names: list[str], corner: tuple[float, float], first: int, turn_deg: float, side: Side) -> list[Place]:
    """Put parts on shelves from the lower left corner of a cluster on, the largest first."""
    places: list[Place] = []
    x = y = _APART_MM
    shelf = 0.0
    for number, package in enumerate(names):
        middle, size = _extent(package, turn_deg, side)
        if x + size[0] + _APART_MM > _CLUSTER_MM:
            x, y, shelf = _APART_MM, y + shelf + _APART_MM, 0.0
        if y + size[1] + _APART_MM / 2 > _CLUSTER_MM:
            raise ValueError(f"{package} does not fit on its cluster; make _CLUSTER_MM larger")
        at = corner[0] + x + size[0] / 2 - middle[0], corner[1] + y + size[1] / 2 - middle[1]
        places.append(Place(f"{_letter(package)}{first + number}", package, *at, turn_deg, None, side))
        x += size[0] + (_NEAR_MM if (number + 1) % _GROUP else _APART_MM)
        shelf = max(shelf, size[1])
    return places


def _extent(package: str, turn_deg: float, side: Side) -> tuple[tuple[float, float], tuple[float, float]]:
    """Middle and size of a part about its own origin, as it lies on the board."""
    shape = shape_of(package)
    points = np.concatenate([solid.reshape(-1, 3) for _, group in shape.solids for solid in group])[:, :2]
    points = points * np.array([1.0 if side == "top" else -1.0, 1.0])
    turn = np.radians(turn_deg)
    turned = points @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    low, high = turned.min(axis=0), turned.max(axis=0)
    (x, y), (width, height) = ((low + high) / 2).tolist(), (high - low).tolist()
    return (x, y), (width, height)


def _letter(package: str) -> str:
    """Reference designator of a package: R, C, D, J, Q or U."""
    known = {"R_": "R", "C_": "C", "CP": "C", "D_": "D", "Pi": "J", "SO": "Q" if package == "SOT-23" else "U"}
    return known.get(package[:2], "U")
