"""``washboard calibrate``: fit nozzles and kinetics to measurements."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from commandline.arguments import complete_parameters, complete_recipe

app = typer.Typer(help="Fit nozzles and kinetics to measurements of your own.", no_args_is_help=True)

Data = Annotated[Path, typer.Argument(help="Table of measurements.", metavar="DATA.csv")]
Picture = Annotated[
    Path | None,
    typer.Option("--picture", help="Picture of measurements and fit to write.", metavar="PNG|SVG"),
]
NozzleName = Annotated[
    str | None, typer.Option("--nozzle", help="Hollow cone of the recipe; left out: its only one.", metavar="NAME")
]


@app.command()
def ring(
    data: Data,
    recipe: Annotated[
        str,
        typer.Option(
            "--recipe",
            help="Recipe whose nozzle was measured; the new one is a copy with the fitted ring.",
            metavar="RECIPE",
            autocompletion=complete_recipe,
        ),
    ] = "smt-aqueous",
    nozzle: NozzleName = None,
    quantity: Annotated[
        Literal["volume", "pressure"],
        typer.Option("--quantity", help="What intensities stand for: water-sensitive paper, or pressure film."),
    ] = "volume",
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="New recipe; left out: the nozzle's lines are printed.", metavar="OUT.yaml"
        ),
    ] = None,
    picture: Picture = None,
) -> None:
    """Fit half angle, spread and irregularity of a hollow cone to patterns on flat sheets.

    Columns: height_mm, tilt_deg, azimuth_deg, inner_mm, outer_mm; or intensity with x_mm, y_mm.

    [dim]washboard calibrate ring pattern.csv
    washboard calibrate ring pattern.csv --recipe mine.yaml --nozzle ring60 -o measured.yaml --picture ring.png[/dim]
    """
    from cleaning.calibration.fit_ring import calibrate_ring
    from cleaning.calibration.nozzle_yaml import choose_nozzle, nozzle_text, recipe_with_ring
    from reports.cards.calibration import ring_card
    from reports.files.atomic_write import write_outputs
    from reports.files.write_run import check_places
    from reports.pictures.calibration_picture import draw_ring
    from reports.terminal.console import open_console, print_card, print_files

    check_places((data, recipe), {"a YAML file": output, "a picture": picture})
    name, _ = choose_nozzle(recipe, nozzle)
    fit = calibrate_ring(data, quantity)
    text = None if output is None else recipe_with_ring(fit, recipe, name, output)
    drawn = None if picture is None else draw_ring(fit, picture.suffix)
    write_outputs({output: text, picture: drawn})
    console = open_console()
    print_card(console, ring_card(fit))
    if text is None:
        typer.echo(nozzle_text(fit), nl=False)
    print_files(console, recipe=output, picture=picture)


@app.command()
def pattern(data: Data, picture: Picture = None) -> None:
    """Fit the radial profile of a round jet to films on flat sheets, and print it as the lines of a nozzle.

    Columns: height_mm, radius_mm (or x_mm, y_mm), film_um; where known time_s (gives the flow), tilt_deg, azimuth_deg.

    [dim]washboard calibrate pattern films.csv --picture pattern.png[/dim]
    """
    from cleaning.calibration.fit_pattern import calibrate_pattern, pattern_text
    from reports.cards.calibration import pattern_card
    from reports.files.atomic_write import write_outputs
    from reports.files.write_run import check_places
    from reports.pictures.calibration_picture import draw_pattern
    from reports.terminal.console import open_console, print_card, print_files

    check_places((data,), {"a picture": picture})
    fit = calibrate_pattern(data)
    write_outputs({picture: None if picture is None else draw_pattern(fit, picture.suffix)})
    console = open_console()
    print_card(console, pattern_card(fit))
    typer.echo(pattern_text(fit), nl=False)
    print_files(console, picture=picture)


@app.command()
def gap(
    data: Data,
    parameters: Annotated[
        str,
        typer.Option(
            "--parameters",
            help="Parameter set to begin with; the new one extends it.",
            metavar="PARAMETERS",
            autocompletion=complete_parameters,
        ),
    ] = "default",
    recipe: Annotated[
        str,
        typer.Option("--recipe", help="Recipe that has the nozzle.", metavar="RECIPE", autocompletion=complete_recipe),
    ] = "smt-aqueous",
    nozzle: NozzleName = None,
    solution: Annotated[
        str | None,
        typer.Option("--solution", help="Liquid of the set; left out: its first for washing.", metavar="NAME"),
    ] = None,
    date: Annotated[str, typer.Option("--date", help="Of the measurement, for its provenance.", metavar="DATE")] = "",
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="New parameter set; left out: it is printed.", metavar="OUT.yaml"),
    ] = None,
    picture: Picture = None,
) -> None:
    """Fit the kinetics of the residue to what was cleaned under glass coupons.

    Columns: standoff_um, time_s, temperature_c, pressure_bar, cleaned_fraction.

    [dim]washboard calibrate gap coupons.csv --date 2026-11-21 -o our-line.yaml --picture coupons.png[/dim]
    """
    from cleaning.calibration.coupon import CouponSetup
    from cleaning.calibration.fit_kinetics import calibrate_gap
    from cleaning.calibration.fitted_parameters import calibrated_set
    from cleaning.calibration.nozzle_yaml import choose_nozzle
    from cleaning.parameters.load import load_parameters
    from commandline.loading import progress_bar
    from reports.cards.calibration import choose_solution, gap_card
    from reports.files.atomic_write import write_outputs
    from reports.files.write_run import check_places
    from reports.pictures.calibration_picture import draw_gap
    from reports.terminal.console import open_console, print_card, print_files

    check_places((data, recipe, parameters), {"a YAML file": output, "a picture": picture})
    known = load_parameters(parameters)
    setup = CouponSetup(choose_nozzle(recipe, nozzle)[1], choose_solution(known, solution), known)
    with progress_bar() as progress:
        fit = calibrate_gap(data, setup, progress)
    text = calibrated_set(fit, parameters, output or Path("calibrated.yaml"), date)
    drawn = None if picture is None else draw_gap(fit, picture.suffix)
    write_outputs({output: text, picture: drawn})
    console = open_console()
    print_card(console, gap_card(fit))
    if output is None:
        typer.echo(text, nl=False)
    print_files(console, parameters=output, picture=picture)
