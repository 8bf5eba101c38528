"""Judge the model by references: ratios and exponents against what was accepted before."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np

from cleaning.parameters.load import load_parameters
from cleaning.parameters.model import Parameters
from cleaning.validation.quantities import QUANTITIES, Compared, Quantity, Rows
from cleaning.validation.reference import LoadedReference, Reference, load_reference, reference_library
from geometry.arrays import Scalars
from specs.progress import Progress, no_progress

Standing: TypeAlias = Literal["holds", "expected failure", "fails", "holds unexpectedly"]
_NOT_OVERTAKEN = 1.0 + 1e-9


@dataclass(frozen=True, slots=True)
class Check:
    """One thing that was accepted beforehand, and what was found."""

    name: str
    """Key of ``accept``, such as ``exponent.flow_g_s``."""
    accepted: str
    found: str
    """Empty where the model predicts nothing."""
    passed: bool


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """The model against one reference."""

    reference: Reference
    compared: Compared
    checks: tuple[Check, ...]

    @property
    def quantity(self) -> Quantity:
        """What is predicted."""
        return QUANTITIES[self.reference.quantity]

    @property
    def ratios(self) -> Scalars:
        """(k,) predicted over published, of the rows that have both."""
        published, predicted = self.compared.rows.published, self.compared.predicted
        both = np.isfinite(predicted) & np.isfinite(published) & (published != 0.0)
        return np.asarray(predicted[both] / published[both], dtype=np.float64)

    @property
    def standing(self) -> Standing:
        """Whether all that is accepted holds, or exactly that fails which is expected to."""
        failed = [check.name for check in self.checks if not check.passed]
        expected = self.reference.expected_failure
        if expected is None:
            return "fails" if failed else "holds"
        if set(failed) - set(expected.checks):
            return "fails"
        return "expected failure" if set(failed) == set(expected.checks) else "holds unexpectedly"

    @property
    def as_expected(self) -> bool:
        """Whether nobody has to look at it."""
        return self.standing in ("holds", "expected failure")


def validate(
    sources: Sequence[str | Path] = (),
    parameters: Parameters | None = None,
    progress: Progress = no_progress,
) -> tuple[Comparison, ...]:
    """Compare the model with references.

    Args:
        sources: Names of the library, folders, or their files; left out: the whole library.
        parameters: Of the model; left out: the default set, of which the expected failures are.
        progress: Receives the reference and the share done.

    Raises:
        CleaningError: one of them cannot be used; the message names the file and the line.
    """
    known = load_parameters() if parameters is None else parameters
    loaded = [load_reference(source) for source in sources or reference_library()]
    found: list[Comparison] = []
    for at, each in enumerate(loaded):
        progress(each.reference.reference, at / len(loaded))
        found.append(compare(each, known))
    return tuple(found)


def compare(loaded: LoadedReference, parameters: Parameters) -> Comparison:
    """Predict what a reference holds, and judge."""
    reference = loaded.reference
    compared = QUANTITIES[reference.quantity].compare(loaded.rows, parameters)
    return Comparison(reference, compared, tuple(_checks(reference, compared)))


def exponent(rows: Rows, values: Scalars, name: str) -> float | None:
    """Power with which values (n,) go with a column, among rows that agree in all other columns.

    Returns:
        ``None`` where no two such rows differ in it, or a value is not above 0.
    """
    others = [column.tolist() for key, column in rows.columns.items() if key != name]
    keys = list(zip(*others, strict=True)) if others else [()] * len(values)
    logs = np.log(np.maximum(rows.columns[name], 1e-300))
    if not np.isfinite(values).all() or (values <= 0.0).any():
        return None
    x, y = np.zeros(len(values)), np.zeros(len(values))
    for key in set(keys):
        here = np.array([each == key for each in keys])
        x[here], y[here] = logs[here] - logs[here].mean(), np.log(values[here]) - np.log(values[here]).mean()
    square = float(x @ x)
    return float(x @ y) / square if square > 0.0 else None


def _power(power: float | None) -> str:
    return "none" if power is None else f"{round(power, 2) + 0.0:.2f}"  # 0 has no sign


def _checks(reference: Reference, compared: Compared) -> Iterator[Check]:
    accept, rows = reference.accept, compared.rows
    ratios = Comparison(reference, compared, ()).ratios
    if accept.ratio is not None:
        low, high = accept.ratio
        found = f"{ratios.min():.3g} to {ratios.max():.3g}" if ratios.size else ""
        inside = bool(ratios.size) and bool(((ratios >= low) & (ratios <= high)).all())
        yield Check("ratio", f"{low:g} to {high:g}", found, inside)
    if accept.mean_ratio is not None:
        low, high = accept.mean_ratio
        mean = mean_ratio(ratios)
        inside = mean is not None and low <= mean <= high
        yield Check("mean_ratio", f"{low:g} to {high:g}", "" if mean is None else f"{mean:.3g}", inside)
    for name, (least, most) in accept.exponent.items():
        power = exponent(rows, compared.predicted, name)
        inside = power is not None and least <= power <= most
        words = "" if power is None else f"{_power(power)}, published {_power(exponent(rows, rows.published, name))}"
        yield Check(f"exponent.{name}", f"{least:g} to {most:g}", words, inside)
    if accept.in_range is not None:
        within = (rows.published >= compared.low) & (rows.published <= compared.high)
        share = float(within.mean())
        words = f"{int(within.sum())} of {len(within)}"
        yield Check("in_range", f"at least {accept.in_range:.0%} of rows", words, share >= accept.in_range)
    if accept.ranking:
        yield _ranking(rows.published, compared.predicted)
    if accept.order:
        values = dict(zip(rows.labels, compared.predicted.tolist(), strict=True))
        falling = [values[label] for label in accept.order]
        passed = all(a > b for a, b in pairwise(falling))
        words = ", ".join(f"{label} {values[label]:.3g}" for label in accept.order)
        yield Check("order", " above ".join(accept.order), words, passed)


def mean_ratio(ratios: Scalars) -> float | None:
    """Geometric mean; ``None`` where there is none."""
    return float(np.exp(np.log(ratios).mean())) if ratios.size and (ratios > 0.0).all() else None


def _ranking(published: Scalars, predicted: Scalars) -> Check:
    """Whether no two rows that differ in what was published are predicted the other way round."""
    above = published[:, None] > published[None, :] * _NOT_OVERTAKEN
    wrong = int((above & ~(predicted[:, None] > predicted[None, :])).sum())
    return Check("ranking", "as published", f"{int(above.sum()) - wrong} of {int(above.sum())} pairs", wrong == 0)


def comparison_data(found: Sequence[Comparison]) -> dict[str, object]:
    """Comparisons as plain data; what the model does not predict is ``None``."""
    return {
        "as_expected": all(each.as_expected for each in found),
        "references": [_data(each) for each in found],
    }


def _data(each: Comparison) -> dict[str, object]:
    reference, (rows, predicted, low, high) = each.reference, each.compared
    stated = reference.model_dump(mode="json", exclude={"conditions"})
    table = [
        {
            "label": label,
            **{name: column[at].item() for name, column in rows.columns.items()},
            "published": _number(rows.published[at]),
            "predicted": _number(predicted[at]),
            "range": [_number(low[at]), _number(high[at])],
        }
        for at, label in enumerate(rows.labels)
    ]
    return {
        **stated,
        "standing": each.standing,
        "mean_ratio": mean_ratio(each.ratios),
        "ratios": [float(ratio) for ratio in each.ratios],
        "checks": [
            {"check": one.name, "accepted": one.accepted, "found": one.found or None, "passed": one.passed}
            for one in each.checks
        ],
        "rows": table,
    }


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
