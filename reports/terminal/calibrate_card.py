"""Result of a calibration on the terminal."""

import math

from rich.console import Console
from rich.text import Text

from cleaning.calibration.confidence import Estimate
from cleaning.calibration.fit_kinetics import FITTED, GapFit
from cleaning.calibration.fit_pattern import PatternFit, sheet_rms
from cleaning.calibration.fit_ring import RingFit
from cleaning.calibration.measurements import Measurements
from cleaning.errors import CleaningError
from cleaning.parameters.model import Liquid, Parameters
from reports.tables.table import Table
from reports.tables.wording import amount
from reports.terminal.console import print_table
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
    rows = [
        ("half_angle_deg", *_estimate(fit.half_angle_deg), "degrees"),
        ("ring_sigma_deg", *_estimate(fit.sigma_deg), "degrees"),
    ]
    print_table(console, Table.of(("", ">fitted", ">95 %", ""), rows))
    if fit.waves_deg:
        console.print(f"The half angle varies about the axis: {_waves(fit.waves_deg, ' degrees')}.")
    else:
        console.print("Within the scatter of the measurements, the ring is a circle.")
    if fit.gain:
        console.print(f"Its strength varies, for which a recipe has no key: {_waves(fit.gain, '')}.")
    sheets = [
        (
            f"{sheet.height_mm:g} mm, tilted {sheet.tilt_deg:g} degrees", str(sheet.samples), f"{sheet.rms:.3g}",
            f"{sheet.bias:+.3g}",
        )
        for sheet in fit.sheets
    ]  # fmt: skip
    print_table(console, Table.of(("sheet", ">rows", ">rms", f">mean, {fit.unit}"), sheets))
    if len({sheet.tilt_deg for sheet in fit.sheets}) == 1:
        console.print("All sheets have one tilt: a skewed nozzle cannot be distinguished from an irregular ring.")


def print_pattern(console: Console, fit: PatternFit) -> None:
    """Print how well the profile meets each sheet, and what landed."""
    _print_source(console, fit.measurements, f"rms {fit.rms:.3g} of the peak")
    rows = [
        (f"{height:g} mm, tilted {tilt:g} degrees", str(count), f"{rms:.3g}")
        for height, tilt, count, rms in sheet_rms(fit)
    ]
    print_table(console, Table.of(("sheet", ">rows", ">rms of the peak"), rows))
    if fit.flow_lpm is None:
        console.print("Without a column time_s the flow that lands is unknown: state flow_lpm yourself.")


def print_gap(console: Console, fit: GapFit) -> None:
    """Print the kinetics, and what the coupons do not determine."""
    measurements = fit.coupons.measurements
    _print_source(console, measurements, f"rms {fit.rms:.3g} of the cleaned fraction")
    before = fit.coupons.setup.parameters
    rows: list[tuple[str, ...]] = []
    for name in FITTED:
        block, _, key = name.partition(".")
        known = f"{getattr(before.soil if block == 'soil' else before.film, key):g}"
        if name in fit.estimates:
            rows.append((name, *_estimate(fit.estimates[name]), known, ""))
            continue
        low, high = fit.undetermined[name].low, fit.undetermined[name].high
        bounds = f"at most {high:.3g}" if low <= 0.0 else f"{low:.3g} to {high:.3g}"
        if math.isinf(high):
            bounds = f"at least {low:.3g}" if low > 0.0 else "any"
        rows.append((name, "undetermined", bounds, known, "stays as it was"))
    print_table(console, Table.of(("", ">fitted", ">95 %", ">before", ""), rows))
    if measurements.synthetic:
        console.print("The table is marked as synthetic: verdicts keep their grade.")


def _estimate(estimate: Estimate) -> tuple[str, str]:
    return f"{estimate.value:.4g}", f"{estimate.low:.4g} to {estimate.high:.4g}"


def _print_source(console: Console, measurements: Measurements, how_well: str) -> None:
    made_up = "  SYNTHETIC" if measurements.synthetic else ""
    console.print(Text(f"{measurements.source}: {len(measurements)} rows, {how_well}{made_up}"), soft_wrap=True)
    repeated = measurements.repeated
    if repeated:
        line, earlier = repeated[0]
        verb = "repeats" if len(repeated) == 1 else "repeat"
        console.print(
            f"{amount(len(repeated), 'row')} {verb} an earlier one, first line {line} as line {earlier}: what was "
            "pasted twice makes intervals too narrow."
        )


def _waves(amplitudes: tuple[float, ...], unit: str) -> str:
    """Size and direction of each harmonic."""
    waves: list[str] = []
    for order, (cosine, sine) in enumerate(zip(amplitudes[::2], amplitudes[1::2], strict=True), 1):
        most = math.degrees(math.atan2(sine, cosine)) / order % (360 / order)
        times = "once" if order == 1 else "twice"
        waves.append(f"{math.hypot(cosine, sine):.2g}{unit} {times} around, most at {most:.0f} degrees")
    return ", ".join(waves)
