"""The library of an IDF board (``.emp``): outline and height of each package."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from shapely import Polygon

from boards.formats.idf.text import Record, Section, read_loops, read_sections, unit_mm
from boards.formats.names import some
from boards.packages.heights import CheckedHeight, HeightEvidence, checked_height
from geometry.arrays import Points2

_FLAT = re.compile(r"(?:^|[^a-z])(?:fid|tp\d|art_tp|test|mtg|hole|logo|label|mark|fiducial)", re.IGNORECASE)
"""Names of copper and print without a body, which layout tools place as packages without a height, or nearly."""

_FLAT_MM = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class Package:
    """One outline of the library."""

    head: Record
    name: str
    part: str
    ring: Points2
    """Open ring, mm, about the package's own origin."""
    height_mm: float

    @property
    def flat(self) -> bool:
        """Whether it is a fiducial, a test point or the like: hardly any height, and the name of one."""
        return 0.0 <= self.height_mm <= _FLAT_MM and bool(_FLAT.search(self.name) or _FLAT.search(self.part))


def seated_height(package: Package, reference: str) -> CheckedHeight:
    """Check the library's height against the sizes that the package's name, part number and family state.

    Raises:
        BoardError: There is no height, and nothing is known of the package.
    """
    x, y = np.ptp(package.ring, axis=0).tolist()
    evidence = HeightEvidence(package.name, reference, (package.part,), length_mm=max(x, y))
    checked = checked_height(package.height_mm, evidence)
    if package.height_mm < 0.0 or (package.height_mm == 0.0 and checked.height.source == "assumed"):
        raise package.head.error(f"package {package.name} has no height. State it in the library.")
    return checked


def find_packages(placed: Sequence[tuple[Record, str, str]], library: Path | None) -> list[Package]:
    """Find the outline of each placement: by package and part number, else by package alone.

    Several outlines of one package that differ in the part number only: the highest is taken, to stay clear of it.

    Args:
        placed: Record of the placement, package and part number.
        library: The ``.emp``, if there is one.

    Raises:
        BoardError: There is no library, or a package is not in it.
    """
    if not placed:
        return []
    if library is None:
        record = placed[0][0]
        raise record.error(f"the library {record.file.stem}.emp is not beside the board file. Put it there.")
    packages = [
        _read_package(section) for section in read_sections(library) if section.name in ("ELECTRICAL", "MECHANICAL")
    ]
    exact = {(package.name, package.part): package for package in reversed(packages)}
    loose: dict[str, Package] = {}
    for package in packages:
        if package.name not in loose or package.height_mm > loose[package.name].height_mm:
            loose[package.name] = package
    missing = [record for record, name, _ in placed if name not in loose]
    if missing:
        names = list(dict.fromkeys(record.fields[0] for record in missing))
        raise missing[0].error(f"not in the library {library.name}: {some(names)}. Export board and library together.")
    return [exact.get((name, part), loose[name]) for _, name, part in placed]


def _read_package(section: Section) -> Package:
    section.need(2)
    head = section.records[0]
    if len(head.fields) < 3:
        raise head.error("a package begins with its name, part number, unit and height.")
    scale_mm = unit_mm(head, 2)
    height_mm = head.length(3, f"height of package {head.fields[0]}", scale_mm)
    points = [record for record in section.records[1:] if record.fields[0].upper() != "PROP"]
    loops = read_loops(points, scale_mm)
    if not loops:
        raise head.error(f"package {head.fields[0]} has no outline.")
    ring = max((ring for _, ring in loops), key=lambda ring: round(Polygon(ring).area, 4))
    return Package(head, head.fields[0], head.fields[1], ring, height_mm)
