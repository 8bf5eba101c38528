"""The tables of a study: every run, the components under the tolerances, main effects; as CSV and Parquet."""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from typing import TypeAlias

from specs.yaml.located import spell_path
from studies.planned_study import Case, PlannedStudy
from studies.results.summary import Run, Summary

RUNS, COMPONENTS, EFFECTS = "runs", "components", "effects"
"""Names of the tables in a study's folder."""

Cell: TypeAlias = str | float | int | bool | None
Columns: TypeAlias = dict[str, list[Cell]]
"""By heading; all of one length."""


def runs_table(planned: PlannedStudy, summary: Summary, runs: Iterable[Run]) -> Columns:
    """List every run, in the order of the study."""
    front = {each.planned.case.number for cases in summary.fronts.values() for each in cases}
    return _columns(_row(planned, run, front) for run in runs)


def components_table(planned: PlannedStudy, summary: Summary) -> Columns:
    """List how often each component comes out clean under the tolerances."""
    rows: list[dict[str, Cell]] = []
    for case in summary.cases:
        begin = _case(planned, case.planned.case)
        for each in case.shares:
            low, high = each.interval
            rows.append({
                **begin,
                "component": each.component,
                "as_planned": each.as_planned,
                "samples": each.samples,
                "clean": each.clean,
                "probability_clean": each.share,
                "low_95": low,
                "high_95": high,
            })  # fmt: skip
    return _columns(rows)


def effects_table(summary: Summary) -> Columns:
    """List the means at each level of each factor, and how they differ from those of all runs."""
    return _columns([asdict(each) for each in summary.effects])


def csv_bytes(table: Columns) -> bytes:
    """Write a table as CSV: numbers with all their digits, nothing where there is nothing."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table)
    writer.writerows(zip(*table.values(), strict=True))
    return text.getvalue().encode("utf-8", errors="replace")


def parquet_bytes(table: Columns) -> bytes:
    """Write a table as Parquet; of a column with numbers and words all are words."""
    import pyarrow
    import pyarrow.parquet

    columns = {name: pyarrow.array(_of_one_kind(values)) for name, values in table.items()}
    buffer = io.BytesIO()
    pyarrow.parquet.write_table(pyarrow.table(columns), buffer)
    return buffer.getvalue()


def _row(planned: PlannedStudy, run: Run, front: set[int]) -> dict[str, Cell]:
    result, deviation, good = run.result, dict(run.deviation), not run.result.error
    named = () if planned.study.tolerances is None else planned.study.tolerances.deviations
    counts = run.counts
    row: dict[str, Cell] = _case(planned, run.case)
    row |= {"sample": run.sample, **{name: deviation.get(name, 0.0) for name in named}}
    row |= {
        "seconds": result.seconds if good else None,
        "litres": result.litres if good else None,
        "verdict": result.verdict,
        "components": run.components if good else None,
        "clean": run.clean if good else None,
        "marginal": counts.get("marginal", 0) if good else None,
        "dirty": counts.get("dirty", 0) if good else None,
        "no_verdict": counts.get("no verdict", 0) if good else None,
        "stay_wet": result.stay_wet if good else None,
        "pareto": run.sample == 0 and run.case.number in front,
    }
    if planned.cell is not None:
        cell = result.cell
        row |= {
            "robot_can": None if cell is None else cell.possible and not cell.errors,
            "robot_errors": None if cell is None else " ".join(cell.errors),
            "robot_seconds": None if cell is None or not cell.possible else cell.seconds,
        }
    hashes = {"program_sha256": result.program_sha256, "analysis_sha256": result.analysis_sha256}
    return row | hashes | {"job": result.job, "error": result.error}


def _case(planned: PlannedStudy, case: Case) -> dict[str, Cell]:
    point: dict[str, Cell] = {spell_path(path): value for path, value in zip(planned.paths, case.point, strict=True)}
    names = {"board": case.board.name, "recipe": case.recipe.name, "parameters": case.parameters.name}
    return {"case": case.number, **names, **point}


def _columns(rows: Iterable[Mapping[str, Cell]]) -> Columns:
    """Turn rows that have the same names into columns, one row at a time."""
    columns: Columns = {}
    for row in rows:
        for name, value in row.items():
            columns.setdefault(name, []).append(value)
    return columns


def _of_one_kind(values: Sequence[Cell]) -> list[Cell]:
    kinds = {type(value) for value in values if value is not None}
    if kinds == {int, float}:
        return [None if value is None else float(value) for value in values]
    return [None if value is None else str(value) for value in values] if len(kinds) > 1 else list(values)
