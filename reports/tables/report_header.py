"""By what a cleaning report was made: which version of Washboard, and how thoroughly it looked."""

from dataclasses import dataclass
from importlib.metadata import version
from typing import TYPE_CHECKING

from specs.json import Json

if TYPE_CHECKING:
    from cleaning.analyse import Effort


@dataclass(frozen=True, slots=True)
class Made:
    """By what a report was made."""

    version: str
    """Of Washboard."""
    effort: "Effort"

    def __str__(self) -> str:
        """Write both as a person reads them."""
        return f"Washboard {self.version}, effort {self.effort}"


def made_here(effort: "Effort") -> Made:
    """Say that the Washboard that runs makes a report."""
    return Made(version("washboard"), effort)


def tell_made(told: dict[str, Json], made: Made) -> dict[str, Json]:
    """Add to a report as plain data by what it was made, next to the version of the data, which comes first."""
    (first, of_data), *rest = told.items()
    return {first: of_data, "washboard": made.version, "effort": made.effort, **dict(rest)}
