"""A placement as one page of HTML that needs nothing else: its value, configurations, worst point, map."""

from html import escape

from reports.html.page import image, section, table_html, whole_page
from reports.pictures.placement_picture import placement_picture
from reports.pictures.sheet import ACCENT, INK
from reports.tables.placement_tables import configuration_table, failing_table, placement_facts
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
    facts = placement_facts(details, mapped)
    colour = INK if details.score.value >= 0.0 else ACCENT
    title = f"{workpiece} in {cell.name}"
    first, *others = facts
    lines = "".join(f"<p><b>{escape(name)}</b> {escape(text)}</p>" for name, text in others)
    head = (
        f'<header><p class="q">{escape(title)} ({escape(cell.robot.name)}), {len(details.targets.tool)} points</p>'
        f'<h1 style="border-color:{colour}">{escape(first[0])}: {escape(first[1])}</h1>{lines}</header>'
    )
    note = f'<p class="q">{escape(_NOTE)}</p>'
    sections = [
        head,
        section(
            "Configurations", note, table_html(configuration_table(details)), image(placement_picture(details, mapped))
        ),
        section("Points that fail", table_html(failing_table(details))),
        section("The place", f"<pre><code>{escape(yaml)}</code></pre>"),
    ]
    return whole_page(f"{title}: placement", sections)
