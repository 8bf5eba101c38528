"""A placement as one page of HTML that needs nothing else: its value, configurations, worst point, map."""

from reports.cards.placement import configuration_table, failing_table, placement_facts
from reports.html.page import blocks_html, header, image, quiet, section, table_html, whole_page
from reports.pictures.placement_picture import placement_picture
from reports.pictures.sheet import ACCENT, INK
from reports.tables.table import FactList, Verbatim, capital
from robotcell.placement.configurations import PlacementDetails
from robotcell.placement.placement_map import PlacementMap

_NOTE = (
    "Each configuration by itself: boxes hold the middle half of the points, whiskers go from the 5th to the 95th "
    "percentile, the dot is the worst point. Grey nodes of the map are not feasible at any yaw; the map is made of "
    "some of the points and without the bodies, its best node of all points and with them."
)


def placement_page(workpiece: str, details: PlacementDetails, mapped: PlacementMap | None, yaml: str) -> str:
    """Write the page; the same placement gives the same text.

    Args:
        workpiece: Name of the board or part.
        details: The placement.
        mapped: The map, if one was made.
        yaml: Lines of the cell's file that hold the workpiece there.
    """
    cell = details.cell
    colour = INK if details.score.value >= 0.0 else ACCENT
    title = f"{workpiece} in {cell.name}"
    (name, value), *others = placement_facts(details, mapped)
    about = f"{title} ({cell.robot.name}), {len(details.targets.tool)} points"
    drawn = image(placement_picture(details, mapped))
    sections = [
        header(about, f"{capital(name)}: {value}", colour, [FactList(others)]),
        section("Configurations", quiet(_NOTE), table_html(configuration_table(details)), drawn),
        section("Points that fail", table_html(failing_table(details))),
        section("The place", blocks_html([Verbatim(yaml)])),
    ]
    return whole_page(f"{title}: placement", sections)
