"""What a calibration found, on the terminal."""

import math

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from cleaning.calibration.confidence import Estimate
from cleaning.calibration.fit_kinetics import FITTED, GapFit
from cleaning.calibration.fit_ring import RingFit
from cleaning.calibration.measurements import Measurements
from cleaning.errors import CleaningError
from cleaning.parameters.model import Liquid, Parameters
from reports.tables.summary import amount
from specs.yaml.schema import name_nearest


def choose_solution(parameters: Parameters, name: str | None) -> Liquid:
    """Find the liquid that coupons were washed with.

    Raises:
        CleaningError: the set has none of that name, or it is not for washing.
    """
    washing = {key: liquid for key, liquid in parameters.liquids.items() if liquid.use == "wash"}
    if not washing:
        raise CleaningError(f"the set {parameters.parameters} has no liquid for washing", path="liquids")
    if name is not None and name not in washing:
        raise CleaningError(f"{name!r} is no liquid for washing; {name_nearest(name, washing)}", path="liquids")
    return washing[name] if name is not None else next(iter(washing.values()))


def print_ring(console: Console, fit: RingFit) -> None:
    """Print the ring, and how well it meets each sheet."""
    _print_source(console, fit.measurements, f"rms {fit.rms:.3g} {fit.unit}")
    table = _table("", ">fitted", ">95 %", "")
    _row(table, "half_angle_deg", fit.half_angle_deg, "degrees", "")
    _row(table, "ring_sigma_deg", fit.sigma_deg, "degrees", "")
    console.print(table)
    if fit.waves_deg:
        console.print(f"The half angle varies about the axis: {_waves(fit.waves_deg, ' degrees')}.")
    else:
        console.print("The ring is a circle, as far as the measurements tell.")
    if fit.gain:
        console.print(f"Its strength varies, which a recipe cannot say: {_waves(fit.gain, '')}.")
    sheets = _table("sheet", ">rows", ">rms", f">mean, {fit.unit}")
    for sheet in fit.sheets:
        name = f"{sheet.height_mm:g} mm, tilted {sheet.tilt_deg:g} degrees"
        sheets.add_row(name, str(sheet.samples), f"{sheet.rms:.3g}", f"{sheet.bias:+.3g}")
    console.print(sheets)
    if len({sheet.tilt_deg for sheet in fit.sheets}) == 1:
        console.print("All sheets have one tilt: a nozzle that points askew cannot be told from an irregular ring.")


def print_gap(console: Console, fit: GapFit) -> None:
    """Print the kinetics, and what the coupons do not tell."""
    measurements = fit.coupons.measurements
    _print_source(console, measurements, f"rms {fit.rms:.3g} of the cleaned fraction")
    table = _table("", ">fitted", ">95 %", ">before", "")
    before = fit.coupons.setup.parameters
    for name in FITTED:
        block, _, key = name.partition(".")
        known = f"{getattr(before.soil if block == 'soil' else before.film, key):g}"
        if name in fit.estimates:
            _row(table, name, fit.estimates[name], known, "")
            continue
        undetermined = fit.undetermined[name]
        table.add_row(name, "not told", _bounds(undetermined.low, undetermined.high), known, "stays as it was")
    console.print(table)
    if measurements.synthetic:
        console.print("The table is marked as synthetic: verdicts keep their grade.")


def _print_source(console: Console, measurements: Measurements, how_well: str) -> None:
    made_up = "  SYNTHETIC" if measurements.synthetic else ""
    told = f"{measurements.source}: {len(measurements)} rows, {how_well}{made_up}"
    console.print(escape(told), soft_wrap=True, highlight=False)
    repeated = measurements.repeated
    if repeated:
        line, earlier = repeated[0]
        says = "says" if len(repeated) == 1 else "say"
        console.print(
            f"{amount(len(repeated), 'row')} {says} the same as an earlier one, first line {line} as line {earlier}: "
            "what was pasted twice makes intervals too narrow."
        )


def _waves(amplitudes: tuple[float, ...], unit: str) -> str:
    """Size and direction of each harmonic."""
    told: list[str] = []
    for order, (cosine, sine) in enumerate(zip(amplitudes[::2], amplitudes[1::2], strict=True), 1):
        most = math.degrees(math.atan2(sine, cosine)) / order % (360 / order)
        times = "once" if order == 1 else "twice"
        told.append(f"{math.hypot(cosine, sine):.2g}{unit} {times} around, most at {most:.0f} degrees")
    return ", ".join(told)


def _bounds(low: float, high: float) -> str:
    if low > 0.0 and math.isinf(high):
        return f"at least {low:.3g}"
    if math.isinf(high):
        return "any"
    return f"at most {high:.3g}" if low <= 0.0 else f"{low:.3g} to {high:.3g}"


def _table(*columns: str) -> Table:
    table = Table(box=None, pad_edge=False, header_style="dim", padding=(0, 2, 0, 0))
    for column in columns:
        table.add_column(column.removeprefix(">"), justify="right" if column.startswith(">") else "left")
    return table


def _row(table: Table, name: str, estimate: Estimate, third: str, fourth: str) -> None:
    table.add_row(name, f"{estimate.value:.4g}", f"{estimate.low:.4g} to {estimate.high:.4g}", third, fourth)
