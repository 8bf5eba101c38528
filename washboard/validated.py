"""The cleaning model against published readings and laws."""

from dataclasses import dataclass
from pathlib import Path

from cleaning.parameters.load import load_parameters
from cleaning.parameters.model import Parameters
from cleaning.validation.compare import Comparison, comparison_data
from cleaning.validation.compare import validate as compare
from specs.progress import Progress, no_progress
from specs.rows import Rows


@dataclass(frozen=True, slots=True)
class ValidationRow:
    """One check of one reference."""

    reference: str
    rests_on: str
    """``readings`` or ``law``."""
    standing: str
    check: str
    accepted: str
    found: str
    passed: bool


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Validated:
    """Comparisons with references."""

    comparisons: tuple[Comparison, ...]

    @property
    def as_expected(self) -> bool:
        """Whether all hold but for those that are expected to fail, and these fail."""
        return all(each.as_expected for each in self.comparisons)

    @property
    def checks(self) -> Rows[ValidationRow]:
        """What was accepted and found."""
        return Rows(
            ValidationRow(
                each.reference.reference,
                each.reference.holds,
                each.standing,
                check.name,
                check.accepted,
                check.found,
                check.passed,
            )
            for each in self.comparisons
            for check in each.checks
        )

    def data(self) -> dict[str, object]:
        """All of it as plain data, with every row."""
        return comparison_data(self.comparisons)

    def __repr__(self) -> str:
        return f"<validation, {len(self.comparisons)} references>"

    def _repr_html_(self) -> str:
        from reports.cards.validation import validation_words

        return f"<p><b>{validation_words(self.comparisons)}</b></p>{self.checks.html()}"


def validate(
    *references: str | Path,
    parameters: Parameters | str | Path = "default",
    progress: Progress = no_progress,
) -> Validated:
    """Compare the cleaning model with what others published.

    Args:
        references: Names of the library, or folders; left out: the whole library.
        parameters: Set of the model; failures that are expected are those of the default one.
        progress: Receives the reference and the share done.

    Raises:
        JobError: a reference or the set cannot be used; the message names the file and the line.
    """
    known = parameters if isinstance(parameters, Parameters) else load_parameters(parameters)
    return Validated(compare(references, known, progress))
