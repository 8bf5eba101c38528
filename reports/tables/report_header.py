"""By what a cleaning report was made: which version of Washboard, and with which effort."""

from dataclasses import dataclass
from importlib.metadata import version
from typing import TYPE_CHECKING

from specs.json import Json

if TYPE_CHECKING:
    from cleaning.analyse import Effort


@dataclass(frozen=True, slots=True)
class Producer:
    """Version of Washboard and effort of an analysis."""

    version: str
    effort: "Effort"

    def __str__(self) -> str:
        """Write both as a person reads them."""
        return f"Washboard {self.version}, effort {self.effort}"

    def add_to(self, report: dict[str, Json]) -> dict[str, Json]:
        """Add both to a report as plain data, after its first key, which is the version of the data."""
        (first, of_data), *rest = report.items()
        return {first: of_data, "washboard": self.version, "effort": self.effort, **dict(rest)}


def this_producer(effort: "Effort") -> Producer:
    """Give the running Washboard as the producer."""
    return Producer(version("washboard"), effort)
