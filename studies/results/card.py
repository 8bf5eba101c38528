"""A study, one of its combinations, and its main effects."""

from collections.abc import Sequence

from reports.tables.table import Bar, Block, Card, Cell, FactList, Table, Text, more_words
from reports.tables.wording import amount, clock
from studies.planned_study import PlannedStudy
from studies.results.read_tables import Combination, StudyTables
from studies.results.summary import CaseSummary, Level, Summary

CAVEAT = "It is a prediction for comparing recipes, no proof of cleanliness."
_MOST_FRONT = 5
_MOST_SHARES = 12
_FRONT = ("case", "recipe", "values", ">time", ">litres", ">clean", ">all clean", "least often clean")
_EFFECTS = ("main effects", "level", ">runs", ">time", ">litres", ">clean")


def study_card(planned: PlannedStudy, summary: Summary, computed: int) -> Card:
    """Show the Pareto front of each board, and the main effects."""
    failed = f"; {amount(summary.failed, 'run')} ended in an error, see the table" if summary.failed else ""
    counts = f": {amount(len(summary.cases), 'combination')}, {amount(computed, 'job')} computed now{failed}"
    blocks: list[Block] = [Text(CAVEAT, "quiet")]
    for board, front in summary.fronts.items():
        if front:
            blocks.append(front_table(planned, front[:_MOST_FRONT], f"{board}: Pareto front"))
        if len(front) > _MOST_FRONT:
            text = f"and {len(front) - _MOST_FRONT} more on the front of {board}, in the table"
            blocks.append(Text(text, "quiet"))
    return Card((Text(planned.study.study, "strong"), counts), (*blocks, effects_rows(summary.effects)))


def front_table(planned: PlannedStudy, front: Sequence[CaseSummary], title: str = "") -> Table:
    """List combinations of a Pareto front: values, time, liquid, clean components, how they bear the tolerances."""
    rows: list[tuple[str, ...]] = []
    for each in front:
        case, result = each.planned.case, each.planned.result
        values = ", ".join(f"{path[-1]} {value}" for path, value in zip(planned.paths, case.point, strict=True))
        weakest = min(each.shares, key=lambda share: share.share, default=None)
        rarest = ""
        if weakest is not None:
            low, high = weakest.interval
            rarest = f"{weakest.component} {weakest.share:.0%} ({low:.0%} to {high:.0%})"
        rows.append((
            str(case.number),
            case.recipe.name,
            values,
            clock(result.seconds),
            f"{result.litres:.2f}",
            f"{each.planned.clean} of {each.planned.components}",
            f"{each.all_clean} of {each.samples}" if each.samples else "",
            rarest,
        ))  # fmt: skip
    return Table.of(_FRONT, rows, title)


def effects_rows(levels: Sequence[Level]) -> Table:
    """List main effects, the name of each factor once."""
    rows: list[tuple[str, ...]] = []
    before = ""
    for each in levels:
        name = each.factor if each.factor != before else ""
        before = each.factor
        rows.append((
            name,
            each.level,
            str(each.runs),
            f"{each.seconds_effect:+z.1f} s",
            f"{each.litres_effect:+z.2f}",
            f"{each.clean_pct_effect:+z.1f} %",
        ))  # fmt: skip
    return Table.of(_EFFECTS, rows)


def tables_card(name: str, tables: StudyTables) -> Card:
    """Show how much a study has."""
    failed = sum(bool(each.error) for each in tables.combinations)
    words = [amount(len(tables.combinations), "combination"), amount(len(tables.boards), "board")]
    words += [f"{failed} with an error"] if failed else []
    return Card(Text(name, "strong"), (", ".join(words), Text(CAVEAT, "quiet")))


def label_of(tables: StudyTables, combination: Combination) -> str:
    """What sets a combination apart for its board: recipe and parameter set if there are several, and values."""
    several = [
        name
        for name, others in (
            (combination.recipe, {each.recipe for each in tables.combinations}),
            (combination.parameters, {each.parameters for each in tables.combinations}),
        )
        if len(others) > 1
    ]
    return ", ".join([*several, *combination.point]) or combination.recipe


def combination_card(tables: StudyTables, each: Combination) -> Card:
    """Show one combination: what it is, what comes out, and how often each component is clean."""
    facts = [("board", each.board), ("recipe", each.recipe), ("parameters", each.parameters)]
    if each.error:
        facts.append(("error", each.error))
    else:
        counts = [f"{count} {verdict}" for verdict, count in each.verdicts.items() if count]
        facts += [
            ("time", clock(each.seconds)),
            ("liquid", f"{each.litres:.2f} l"),
            ("components", ", ".join(counts) or "none"),
            ("Pareto front", "on it" if each.pareto else "another one is better"),
            *([("robot", each.robot)] if each.robot else []),
            *([("all clean", f"{each.all_clean} of {each.samples} with deviations")] if each.samples else []),
        ]
    values = Table.of(("value", ">"), list(zip(tables.paths, each.point, strict=True)))
    shares = sorted(() if each.error else each.shares, key=lambda share: share.share)
    rows: list[tuple[Cell, ...]] = []
    for share in shares[:_MOST_SHARES]:
        low, high = share.interval
        rows.append((share.component, Bar(share.share, f"{share.share:.0%} ({low:.0%} to {high:.0%})", marked=True)))
    bars = Table.of(("", ""), rows, "Clean under the tolerances, with the 95 % interval")
    more = more_words(len(shares) - _MOST_SHARES, "more often")
    return Card(Text(f"{each.number}", "strong"), (FactList(facts), values, bars, *more))


def effects_card(levels: Sequence[Level]) -> Card:
    """Show main effects: for each level of a factor how its means differ from those of all runs."""
    return Card(Text("How the mean at a level differs from the mean of all.", "quiet"), (effects_rows(levels),))
