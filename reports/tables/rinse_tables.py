"""What rinse tanks carry, in words and tables."""

from cleaning.undersides.rinse import ionic_ug_cm2
from cleaning.verdicts.results import CleaningReport
from reports.tables.table import Table
from reports.tables.wording import short_number

_TANKS = ("rinse tank", ">litres", ">salt in its water, g/m³", ">MΩ·cm", ">exchanged on a board",
          ">left by its film, µg/cm²")  # fmt: skip


def rinse_words(report: CleaningReport) -> list[str]:
    """What boards carry from tank to tank, in a sentence; none where there are no tanks."""
    water = report.rinse_water
    if water is None:
        return []
    cascade = water.cascade
    feed = "overflows from the last tank to the first" if cascade.counter_current else "enters each tank"
    tanks = ", ".join(
        f"{tank.solution} has {short_number(tank.resistivity_mohm_cm)} MΩ·cm ({short_number(tank.content_g_m3)} g/m³)"
        for tank in water.tanks
    )
    return [
        f"Rinse tanks: {tanks}. Each board carries {short_number(1e6 * cascade.carried_m3)} ml from the bath into the "
        f"first and on from tank to tank; {short_number(1e3 * cascade.fresh_m3)} l of fresh water for it {feed}."
    ]


def rinse_table(report: CleaningReport) -> Table:
    """Tanks in the order in which boards pass them; without rows where there are none."""
    film_um = report.parameters.rinse.final_film_um
    rows: list[tuple[str, ...]] = []
    for tank in [] if report.rinse_water is None else report.rinse_water.tanks:
        left = ionic_ug_cm2(tank.on_board_g_m3, film_um)
        numbers = (1e3 * tank.volume_m3, tank.content_g_m3, tank.resistivity_mohm_cm)
        exchanged = f"{100.0 * (1.0 - tank.kept):.3g} %"
        rows.append((tank.solution, *map(short_number, numbers), exchanged, short_number(left)))
    return Table.of(_TANKS, rows)
