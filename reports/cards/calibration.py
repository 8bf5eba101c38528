"""Result of a calibration: fitted values with their intervals, and how well they meet what was measured."""

import math
from collections.abc import Sequence

from cleaning.calibration.confidence import Estimate
from cleaning.calibration.fit_kinetics import FITTED, GapFit
from cleaning.calibration.fit_spray import PatternFit, RingFit, sheet_rms
from cleaning.calibration.measurements import Measurements
from cleaning.errors import CleaningError
from cleaning.parameters.model import Liquid, Parameters
from reports.tables.table import Block, Card, Table, Verbatim
from reports.tables.wording import amount
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


def ring_card(fit: RingFit) -> Card:
    """Show the ring, and how well it meets each sheet."""
    fitted = {"half_angle_deg": fit.half_angle_deg, "ring_sigma_deg": fit.sigma_deg}
    rows = [(name, *_estimate(each), "degrees") for name, each in fitted.items()]
    blocks: list[Block] = [Table.of(("", ">fitted", ">95 %", ""), rows)]
    if fit.waves_deg:
        blocks.append(f"The half angle varies about the axis: {_waves(fit.waves_deg, ' degrees')}.")
    else:
        blocks.append("Within the scatter of the measurements, the ring is a circle.")
    if fit.gain:
        blocks.append(f"Its strength varies, for which a recipe has no key: {_waves(fit.gain, '')}.")
    sheets = [
        (_sheet_words(each.height_mm, each.tilt_deg), str(each.samples), f"{each.rms:.3g}", f"{each.bias:+z.3g}")
        for each in fit.sheets
    ]
    blocks.append(Table.of(("sheet", ">rows", ">rms", f">mean, {fit.unit}"), sheets))
    if len({sheet.tilt_deg for sheet in fit.sheets}) == 1:
        blocks.append("All sheets have one tilt: a skewed nozzle cannot be distinguished from an irregular ring.")
    return _card(fit.measurements, f"rms {fit.rms:.3g} {fit.unit}", blocks)


def pattern_card(fit: PatternFit) -> Card:
    """Show how well the profile meets each sheet, and what landed."""
    rows = [(_sheet_words(height, tilt), str(count), f"{rms:.3g}") for height, tilt, count, rms in sheet_rms(fit)]
    blocks: list[Block] = [Table.of(("sheet", ">rows", ">rms of the peak"), rows)]
    if fit.flow_lpm is None:
        blocks.append("Without a column time_s the flow that lands is unknown: state flow_lpm yourself.")
    return _card(fit.measurements, f"rms {fit.rms:.3g} of the peak", blocks)


def gap_card(fit: GapFit) -> Card:
    """Show the kinetics, and what the coupons do not determine."""
    measurements = fit.coupons.measurements
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
    blocks: list[Block] = [Table.of(("", ">fitted", ">95 %", ">before", ""), rows)]
    if measurements.synthetic:
        blocks.append("The table is marked as synthetic: verdicts keep their grade.")
    return _card(measurements, f"rms {fit.rms:.3g} of the cleaned fraction", blocks)


def _estimate(estimate: Estimate) -> tuple[str, str]:
    return f"{estimate.value:.4g}", f"{estimate.low:.4g} to {estimate.high:.4g}"


def _sheet_words(height_mm: float, tilt_deg: float) -> str:
    return f"{height_mm:g} mm, tilted {tilt_deg:g} degrees"


def _card(measurements: Measurements, how_well: str, blocks: Sequence[Block]) -> Card:
    """Put the measurements before what was fitted to them, and rows that stand there twice."""
    made_up = "  SYNTHETIC" if measurements.synthetic else ""
    repeated = measurements.repeated
    twice: list[Block] = []
    if repeated:
        line, earlier = repeated[0]
        verb = "repeats" if len(repeated) == 1 else "repeat"
        twice.append(
            f"{amount(len(repeated), 'row')} {verb} an earlier one, first line {line} as line {earlier}: what was "
            "pasted twice makes intervals too narrow."
        )
    source = Verbatim(f"{measurements.source}: {len(measurements)} rows, {how_well}{made_up}")
    return Card("", (source, *twice, *blocks))


def _waves(amplitudes: tuple[float, ...], unit: str) -> str:
    """Size and direction of each harmonic."""
    waves: list[str] = []
    for order, (cosine, sine) in enumerate(zip(amplitudes[::2], amplitudes[1::2], strict=True), 1):
        most = math.degrees(math.atan2(sine, cosine)) / order % (360 / order)
        times = "once" if order == 1 else "twice"
        waves.append(f"{math.hypot(cosine, sine):.2g}{unit} {times} around, most at {most:.0f} degrees")
    return ", ".join(waves)
