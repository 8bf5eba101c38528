"""Fitted kinetics as a parameter set: what was fitted, with its provenance; all else is inherited."""

import json
import os
import re
from pathlib import Path

from cleaning.calibration.fit_kinetics import GapFit
from cleaning.errors import CleaningError
from cleaning.parameters.consistency import is_day
from cleaning.parameters.load import parameter_library, read_parameters_text

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.-]*")


def calibrated_set(fit: GapFit, source: str | Path, file: Path, date: str = "") -> str:
    """Write a parameter set that extends another by what was fitted.

    Args:
        fit: The kinetics.
        source: The set that the fit began with: a library name or a file.
        file: Where the new set will stand; it is named after it.
        date: Of the measurement, as in 2026-11-21; empty if it is not known.

    Raises:
        CleaningError: the file's name cannot be a set's, the date is none, or a fitted value is out of bounds.
    """
    if _NAME.fullmatch(file.stem) is None:
        message = f"{file.stem!r} cannot name a set: begin with a letter; use letters, digits and _ . - only"
        raise CleaningError(message, file=file)
    if date and not is_day(date):
        raise CleaningError(f"{date!r} is no date; write it as in 2026-11-21")
    values = {name: _rounded(estimate.value) for name, estimate in fit.estimates.items()}
    undetermined, synthetic = fit.undetermined.items(), fit.coupons.measurements.synthetic
    fitted = ", ".join(name.partition(".")[2] for name in fit.estimates)
    coupons = "made-up coupons" if synthetic else "coupons"
    description = f"{fitted} fitted to {len(fit.predicted)} {coupons}; all else as {Path(source).stem}."
    base = str(source)
    if base not in parameter_library():  # the way from the new file to the old one
        base = json.dumps(Path(os.path.relpath(Path(source).resolve(), file.parent.resolve())).as_posix())
    lines = [
        f"# Fitted by washboard to {fit.coupons.measurements.source}.",
        *(["# SYNTHETIC data: this proves nothing about a line, and verdicts keep their grade."] * synthetic),
        *(
            f"# {name} is not determined by them and stays {lost.kept:g}; the rest holds with that."
            for name, lost in undetermined
        ),
        f"parameters: {file.stem}",
        f"description: {json.dumps(description)}",
        f"extends: {base}",
    ]
    for block in ("soil", "film"):
        own = {name: value for name, value in values.items() if name.startswith(f"{block}.")}
        lines += [f"{block}:"] * bool(own) + [f"  {name.partition('.')[2]}: {value:g}" for name, value in own.items()]
    lines += ["provenance:", *(_provenance(fit, name, date) for name in values)]
    text = "\n".join(lines) + "\n"
    try:
        read_parameters_text(text, file=file)
    except CleaningError as error:
        message = f"the fitted values cannot be those of a line, so no set was written. It would be refused: {error}"
        raise CleaningError(message) from None
    return text


def _provenance(fit: GapFit, name: str, date: str) -> str:
    estimate, measurements = fit.estimates[name], fit.coupons.measurements
    entry = [
        f"known: {'synthetic' if measurements.synthetic else 'calibrated'}",
        f"source: {json.dumps(measurements.source, ensure_ascii=False)}",
        *([f'date: "{date}"'] if date else []),
        f"samples: {len(measurements)}",
        f"rms: {fit.rms:.3g}",
        f"interval: [{_rounded(estimate.low):g}, {_rounded(estimate.high):g}]",
    ]
    return f"  {name}: {{{', '.join(entry)}}}"


def _rounded(value: float) -> float:
    return float(f"{value:.4g}")
