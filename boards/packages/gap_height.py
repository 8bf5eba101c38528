"""Height of the gap under a part: the one precedence of its sources."""

from dataclasses import dataclass

from boards.packages.families import package_family
from boards.packages.sizes import package_sizes
from boards.packages.undersides import underside_family

STATED = "stated"
UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class GapHeight:
    """Gap between the board and the underside of a body."""

    nominal_mm: float | None
    """For lists and filters: as stated (the least of a range), or the family's nominal height."""
    source: str
    """``"stated"``, ``"stated in the parameter set"``, ``"family SOIC (JEDEC MS-012)"``, or ``"unknown"``."""
    bounds_mm: tuple[float, float] | None
    """Least and largest; equal where one value is stated, ``None`` where no document fixes them."""
    bounds_source: str
    """As ``source``; of a family it gives both bounds."""


def gap_height(
    package: str, board_file_mm: float | None, parameter_set_mm: tuple[float, float] | None = None
) -> GapHeight:
    """Height of the gap from the first source that has one: parameter set, board file, package family.

    Args:
        package: Name of the package; empty if unknown.
        board_file_mm: What the board file or its parts table states.
        parameter_set_mm: Least and largest that a cleaning parameter set states for the part.
    """
    if parameter_set_mm is not None:
        source = f"{STATED} in the parameter set"
        return GapHeight(parameter_set_mm[0], source, parameter_set_mm, source)
    if board_file_mm is not None:
        return GapHeight(board_file_mm, STATED, (board_file_mm, board_file_mm), STATED)
    family = package_family(package) if package else None
    if family is None:
        return GapHeight(None, UNKNOWN, None, UNKNOWN)
    underside = underside_family(family)
    bounds = underside.gap_heights_mm(package_sizes(package).pitch_mm)
    return GapHeight(
        family.gap_height_mm,
        UNKNOWN if family.gap_height_mm is None else f"family {family.name} ({family.source})",
        bounds,
        UNKNOWN if bounds is None else f"family {family.name}: {bounds[0]:g} to {bounds[1]:g} mm ({underside.source})",
    )
