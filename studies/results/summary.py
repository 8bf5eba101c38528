"""What a study found: its rows, Pareto fronts, main effects, and how often each component comes out clean."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from statistics import fmean
from typing import TypeAlias

from rulesengine.tuning.trial.request import non_dominated
from specs.yaml.located import spell_path
from studies.job import JobResult
from studies.planned_study import Case, PlannedStudy
from studies.store import ResultStore
from studies.study import Deviation, LatinHypercube, Scalar

_Z_95 = 1.959963984540054
_THIRDS = 3
"""Levels of what is drawn from a range."""


@dataclass(frozen=True, slots=True)
class Run:
    """One row of the table: a combination, as planned or with deviations, and what came out."""

    case: Case
    sample: int
    """0 as planned; from 1 on, of the tolerances."""
    deviation: Deviation
    result: JobResult

    @property
    def counts(self) -> Mapping[str, int]:
        """Components by their verdict."""
        return Counter(self.result.components.values())

    @property
    def clean(self) -> int:
        """Components that are predicted clean."""
        return self.counts.get("clean", 0)

    @property
    def components(self) -> int:
        """All components that were judged."""
        return len(self.result.components)


def runs_of(planned: PlannedStudy, store: ResultStore) -> Iterator[Run]:
    """Read the results in the order of the study, one at a time.

    Raises:
        StudyError: one cannot be read.
    """
    for case in planned.cases():
        for sample, job in enumerate(planned.jobs_of(case)):
            yield Run(case, sample, job.deviation, store.read(job.key))


@dataclass(frozen=True, slots=True)
class CleanShare:
    """In how many boards of a sample one component comes out clean."""

    component: str
    as_planned: str
    """Verdict without deviations."""
    clean: int
    samples: int

    @property
    def share(self) -> float:
        """The estimate of the probability."""
        return self.clean / self.samples

    @property
    def interval(self) -> tuple[float, float]:
        """Where the probability lies with 95 % confidence."""
        return wilson(self.clean, self.samples)


@dataclass(frozen=True, slots=True)
class CaseSummary:
    """One combination: as planned, and how it bears the tolerances."""

    planned: Run
    shares: tuple[CleanShare, ...]
    """Of each component; empty without tolerances."""
    all_clean: int
    """Samples in which every component comes out clean."""
    samples: int
    """That could be analysed."""


@dataclass(frozen=True, slots=True)
class Level:
    """What a factor does at one level: means over everything else, and how they differ from those of all runs."""

    factor: str
    level: str
    runs: int
    seconds: float
    litres: float
    clean_pct: float
    seconds_effect: float
    litres_effect: float
    clean_pct_effect: float


@dataclass(frozen=True, slots=True)
class Summary:
    """All that a study found."""

    cases: tuple[CaseSummary, ...]
    fronts: Mapping[str, tuple[CaseSummary, ...]]
    """Of each board: combinations that no other one of it is better than, the quickest first."""
    effects: tuple[Level, ...]
    failed: int
    """Runs that ended in an error."""


def summarise(planned: PlannedStudy, runs: Iterator[Run]) -> Summary:
    """Sum up the runs of a study, one combination at a time."""
    cases: list[CaseSummary] = []
    tolerances = planned.study.tolerances
    deviated = _Responses(frozenset(() if tolerances is None else tolerances.deviations))
    failed = 0
    for _, group in groupby(runs, key=lambda run: run.case.number):
        first, *samples = group
        good = [each for each in samples if not each.result.error]
        failed += sum(bool(each.result.error) for each in (first, *samples))
        cases.append(_summarise_case(first, good))
        for each in good:
            deviated.add(each, dict(each.deviation))
    variables = planned.study.variables if isinstance(planned.study.design, LatinHypercube) else []
    nominal = _Responses(frozenset(each.path for each in variables if each.values is None))
    for each in cases:
        if not each.planned.result.error:
            case = each.planned.case
            point = {spell_path(path): value for path, value in zip(planned.paths, case.point, strict=True)}
            named = {"board": case.board.name, "recipe": case.recipe.name, "parameters": case.parameters.name}
            nominal.add(each.planned, named | point)
    boards = dict.fromkeys(each.planned.case.board.name for each in cases)
    of_board = {name: [each for each in cases if each.planned.case.board.name == name] for name in boards}
    fronts = {name: pareto_front(of_board[name]) for name in boards}
    return Summary(tuple(cases), fronts, (*nominal.effects(), *deviated.effects()), failed)


def _summarise_case(planned: Run, samples: Sequence[Run]) -> CaseSummary:
    clean = Counter(name for each in samples for name, verdict in each.result.components.items() if verdict == "clean")
    shares = tuple(
        CleanShare(name, verdict, clean[name], len(samples))
        for name, verdict in planned.result.components.items()
        if samples
    )
    return CaseSummary(planned, shares, sum(each.clean == each.components for each in samples), len(samples))


def pareto_front(cases: Sequence[CaseSummary]) -> tuple[CaseSummary, ...]:
    """Combinations that no other one is better than in time, liquid and clean components together; errors left out.

    With tolerances, how many components come out clean on average counts as well. Of equal ones the first stays.
    """
    good = [each for each in cases if not each.planned.result.error]
    return non_dominated(
        good,
        lambda case: (
            case.planned.result.seconds,
            case.planned.result.litres,
            -case.planned.clean,
            -sum(share.clean for share in case.shares),
        ),
    )


def wilson(successes: int, trials: int) -> tuple[float, float]:
    """Give the 95 % interval of a probability. E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209."""
    share, spread = successes / trials, _Z_95**2 / trials
    middle = share + 0.5 * spread
    half = _Z_95 * math.sqrt(share * (1.0 - share) / trials + 0.25 * spread / trials)
    low, high = (middle - half) / (1.0 + spread), (middle + half) / (1.0 + spread)
    return (0.0 if successes == 0 else low), (1.0 if successes == trials else high)


_Numbers: TypeAlias = tuple[float, float, float]
"""Seconds, litres, percent of components clean."""


@dataclass(slots=True)
class _Responses:
    """Numbers of runs with their factors: short, since a study has many."""

    drawn: frozenset[str]
    """Factors that take values anywhere in a range: their levels are thirds of those values."""
    rows: list[tuple[dict[str, Scalar], _Numbers]] = field(default_factory=list[tuple[dict[str, Scalar], _Numbers]])

    def add(self, run: Run, factors: Mapping[str, Scalar]) -> None:
        """Add a run without error."""
        clean = 100.0 * run.clean / run.components if run.components else 100.0
        self.rows.append((dict(factors), (run.result.seconds, run.result.litres, clean)))

    def effects(self) -> list[Level]:
        """Give the main effects of the factors that take more than one value."""
        if not self.rows:
            return []
        overall = _means([numbers for _, numbers in self.rows])
        found: list[Level] = []
        for factor in self.rows[0][0]:
            rows = [(factors[factor], numbers) for factors, numbers in self.rows]
            levels = _thirds(rows) if factor in self.drawn else _levels(rows)
            if len(levels) < 2:
                continue
            for name, numbers in levels:
                means = _means(numbers)
                effect = [mean - all_ for mean, all_ in zip(means, overall, strict=True)]
                found.append(Level(factor, name, len(numbers), *means, *effect))
        return found


def _levels(rows: Sequence[tuple[Scalar, _Numbers]]) -> list[tuple[str, list[_Numbers]]]:
    """Group runs by the value of a factor, in the order of the study."""
    found: dict[Scalar, list[_Numbers]] = {}
    for value, numbers in rows:
        found.setdefault(value, []).append(numbers)
    return [(f"{value}", each) for value, each in found.items()]


def _thirds(rows: Sequence[tuple[Scalar, _Numbers]]) -> list[tuple[str, list[_Numbers]]]:
    """Group runs by the third of its values in which a factor is: of as many values each."""
    values = sorted({float(value) for value, _ in rows})
    size = len(values) / _THIRDS
    parts = [values[round(at * size) : round((at + 1) * size)] for at in range(_THIRDS)]
    third = {value: at for at, part in enumerate(parts) for value in part}
    found: list[list[_Numbers]] = [[] for _ in parts]
    for value, numbers in rows:
        found[third[float(value)]].append(numbers)
    return [
        (" to ".join(f"{end:.3g}" for end in dict.fromkeys((part[0], part[-1]))), each)
        for part, each in zip(parts, found, strict=True)
        if part
    ]


def _means(rows: Sequence[_Numbers]) -> _Numbers:
    seconds, litres, clean = (fmean(column) for column in zip(*rows, strict=True))
    return seconds, litres, clean
