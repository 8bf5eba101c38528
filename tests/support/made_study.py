"""The folder of a study as the command writes it, with made-up results: nothing is planned or analysed."""

from collections.abc import Iterator
from pathlib import Path

from studies.job import Input, JobResult
from studies.planned_study import PlannedStudy
from studies.results import tables
from studies.results.summary import Run, summarise
from studies.study import Study, design_points, draw_deviations

SPEEDS = (40, 60, 80, 100)
PATHS = "templates.sweep.speed_mm_s", "sequence[0].least_time_s"


def write_made_study(
    folder: Path, boards=("tiny",), recipes=("smt-aqueous",), samples=4, failing=frozenset[int]()
) -> None:
    """Slower sweeps clean more; combinations with numbers in ``failing`` end in an error."""
    variables = [{"path": PATHS[0], "values": list(SPEEDS)}, {"path": PATHS[1], "values": [300, 330]}]
    stated = {"study": "made", "boards": list(boards), "recipes": list(recipes), "variables": variables}
    if samples:
        deviations = {"pressure_pct": {"distribution": "uniform", "low": -9, "high": 9}}
        stated["tolerances"] = {"samples": samples, "deviations": deviations}
    study = Study.model_validate(stated)
    planned = PlannedStudy(
        study,
        tuple(Input(name, f"/{name}", "b" * 64) for name in boards),
        tuple(Input(name, f"/{name}", "r" * 64) for name in recipes),
        (Input("default", "/default.yaml", "p" * 64),),
        None,
        (("templates", "sweep", "speed_mm_s"), ("sequence", 0, "least_time_s")),
        ((None, None),) * len(recipes),
        tuple(design_points(study)),
        tuple(draw_deviations(study.tolerances)),
    )

    def runs() -> Iterator[Run]:
        for case in planned.cases():
            for sample, job in enumerate(planned.jobs_of(case)):
                result = JobResult(job.key, error="too fast") if case.number in failing else made(job.key, case, sample)
                yield Run(case, sample, job.deviation, result)

    summary = summarise(planned, runs())
    (folder / "results" / "ab").mkdir(parents=True)
    for name, table in (
        (tables.RUNS, tables.runs_table(planned, summary, runs())),
        (tables.COMPONENTS, tables.components_table(planned, summary)),
        (tables.EFFECTS, tables.effects_table(summary)),
    ):
        if table:
            (folder / f"{name}.csv").write_bytes(tables.csv_bytes(table))


def made(key: str, case, sample: int) -> JobResult:
    speed, least_s = case.point
    count = 5 - SPEEDS.index(speed) - (1 if sample and sample % 2 and least_s == 300 else 0)
    components = {f"U{number}": "clean" if number <= count else "dirty" for number in range(1, 6)}
    seconds = least_s + 6000 / speed + 7 * len(case.board.name)
    return JobResult(key, "", seconds, seconds / 27.0, "dirty", components, 1)
