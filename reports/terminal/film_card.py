"""Spacings and levelled films on the terminal."""

from rich.console import Console

from reports.tables.table import Table
from reports.terminal.console import print_line, print_table
from rulesengine.levelling.pass_spacing import SpacingTable


def print_spacings(console: Console, table: SpacingTable) -> None:
    """Print every even spacing, its ripple, the speed that lays the film, and whether that is allowed."""
    head = f"{table.film_um:g} µm with {table.nozzle} from {table.height_mm:g} mm, {table.flow_lpm:.4g} l/min"
    print_line(console, (head, "bold"))
    best = table.best
    rows: list[tuple[str, ...]] = []
    for each in table.valleys:
        found, scale = each.spacing, table.film_um / each.spacing.middle
        note = "best" if each is best else "allowed" if each.allowed else "too fast"
        rows.append(
            (
                f"{found.spacing:.3f} mm", f"±{100.0 * found.ripple:.2f} %",
                f"{found.low * scale:.3f} to {found.high * scale:.3f} µm", f"{each.speed_mm_s:.1f} mm/s",
                str(each.overlapping), note,
            )
        )  # fmt: skip
    print_table(console, Table.of((">spacing", ">ripple", ">film", ">speed", ">overlapping", ""), rows))
    limit = f"{table.max_speed_mm_s:g} mm/s ({table.max_speed_of})"
    if not table.valleys:
        console.print("No spacing down to a tenth of the pattern's width is even: hills of one pass remain.")
    elif best is None:
        slowest = table.valleys[0].speed_mm_s
        console.print(
            f"None is allowed by {limit}: the widest needs {slowest:.1f} mm/s. Lower the flow or the pressure, or lay "
            f"at least {table.film_um * slowest / table.max_speed_mm_s:.1f} µm."
        )
    else:
        console.print(f"At most {limit}. Between these spacings the ripple rises to hills; see the picture.")
