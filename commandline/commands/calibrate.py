"""``washboard calibrate``: fit nozzles and kinetics to measurements."""

from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import typer

from commandline.arguments import input_argument, input_option, output_option
from specs.output_file import OutputFile

app = typer.Typer(help="Fit nozzles and kinetics to measurements of your own.", no_args_is_help=True)

Data = Annotated[Path, input_argument("DATA.csv", "Table of measurements.")]
Picture = Annotated[
    OutputFile | None, output_option("--picture", "PNG|SVG", "Picture of measurements and fit to write.")
]
NozzleName = Annotated[
    str | None, typer.Option("--nozzle", help="Hollow cone of the recipe; left out: its only one.", metavar="NAME")
]


@app.command()
def ring(
    data: Data,
    recipe: Annotated[
        str,
        input_option(
            "--recipe", "RECIPE", "Recipe whose nozzle was measured; the new one is a copy with the fitted ring."
        ),
    ] = "smt-aqueous",
    nozzle: NozzleName = None,
    quantity: Annotated[
        Literal["volume", "pressure"],
        typer.Option("--quantity", help="What intensities stand for: water-sensitive paper, or pressure film."),
    ] = "volume",
    output: Annotated[
        OutputFile | None,
        output_option("--output -o", "OUT.yaml", "New recipe; left out: the nozzle's lines are printed."),
    ] = None,
    picture: Picture = None,
) -> None:
    """Fit half angle, spread and irregularity of a hollow cone to patterns on flat sheets.

    Columns: height_mm, tilt_deg, azimuth_deg, inner_mm, outer_mm; or intensity with x_mm, y_mm.

    [dim]washboard calibrate ring pattern.csv
    washboard calibrate ring pattern.csv --recipe mine.yaml --nozzle ring60 -o measured.yaml --picture ring.png[/dim]
    """
    from cleaning.calibration.fit_spray import calibrate_ring
    from cleaning.calibration.fitted_files import choose_nozzle, nozzle_text, recipe_with_ring
    from commandline.loading import finish
    from reports.cards.calibration import ring_card
    from reports.pictures.charts import draw_ring

    name, _ = choose_nozzle(recipe, nozzle)
    fit = calibrate_ring(data, quantity)
    text = nozzle_text(fit) if output is None else recipe_with_ring(fit, recipe, name, output.path)
    printed = [text] if output is None else []
    finish(ring_card(fit), *printed, recipe=(output, text), picture=(picture, partial(draw_ring, fit)))


@app.command()
def pattern(data: Data, picture: Picture = None) -> None:
    """Fit the radial profile of a round jet to films on flat sheets, and print it as the lines of a nozzle.

    Columns: height_mm, radius_mm (or x_mm, y_mm), film_um; where known time_s (gives the flow), tilt_deg, azimuth_deg.

    [dim]washboard calibrate pattern films.csv --picture pattern.png[/dim]
    """
    from cleaning.calibration.fit_spray import calibrate_pattern, pattern_text
    from commandline.loading import finish
    from reports.cards.calibration import pattern_card
    from reports.pictures.charts import draw_pattern

    fit = calibrate_pattern(data)
    finish(pattern_card(fit), pattern_text(fit), picture=(picture, partial(draw_pattern, fit)))


@app.command()
def gap(
    data: Data,
    parameters: Annotated[
        str, input_option("--parameters", "PARAMETERS", "Parameter set to begin with; the new one extends it.")
    ] = "default",
    recipe: Annotated[str, input_option("--recipe", "RECIPE", "Recipe that has the nozzle.")] = "smt-aqueous",
    nozzle: NozzleName = None,
    solution: Annotated[
        str | None,
        typer.Option("--solution", help="Liquid of the set; left out: its first for washing.", metavar="NAME"),
    ] = None,
    date: Annotated[str, typer.Option("--date", help="Of the measurement, for its provenance.", metavar="DATE")] = "",
    output: Annotated[
        OutputFile | None, output_option("--output -o", "OUT.yaml", "New parameter set; left out: it is printed.")
    ] = None,
    picture: Picture = None,
) -> None:
    """Fit the kinetics of the residue to what was cleaned under glass coupons.

    Columns: standoff_um, time_s, temperature_c, pressure_bar, cleaned_fraction.

    [dim]washboard calibrate gap coupons.csv --date 2026-11-21 -o our-line.yaml --picture coupons.png[/dim]
    """
    from cleaning.calibration.coupon import CouponSetup
    from cleaning.calibration.fit_kinetics import calibrate_gap
    from cleaning.calibration.fitted_files import calibrated_set, choose_nozzle
    from cleaning.parameters.load import load_parameters
    from commandline.loading import finish, progress_bar
    from reports.cards.calibration import choose_solution, gap_card
    from reports.pictures.charts import draw_gap

    known = load_parameters(parameters)
    setup = CouponSetup(choose_nozzle(recipe, nozzle)[1], choose_solution(known, solution), known)
    with progress_bar() as progress:
        fit = calibrate_gap(data, setup, progress)
    text = calibrated_set(fit, parameters, output.path if output else Path("calibrated.yaml"), date)
    printed = [text] if output is None else []
    finish(gap_card(fit), *printed, parameters=(output, text), picture=(picture, partial(draw_gap, fit)))
