"""Jobs give what single commands give, byte for byte; files that change while a study runs stop it."""

import csv
import hashlib
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import pytest
import trimesh
from command import contents, washboard

from specs.input_file import InputFile
from specs.progress import no_progress
from studies import run_job as run_job_module
from studies.errors import StudyError
from studies.job import Job
from studies.planned_study import plan_study
from studies.run_job import run_job

STUDY = """study: speeds
boards: [tiny]
recipes: [own.yaml]
variables:
  - {path: templates.sweep.speed_mm_s, values: [50, 70, 100000]}
tolerances:
  samples: 2
  deviations:
    standoff_mm: {distribution: normal, sigma: 1}
"""
OWN = "recipe: own\nextends: rinse-only\n"


def sha256(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def jobs(folder: Path) -> list[Job]:
    (folder / "own.yaml").write_text(OWN)
    (folder / "study.yaml").write_text(STUDY)
    return list(plan_study(folder / "study.yaml", no_progress).jobs())


@pytest.mark.slow
def test_a_job_in_one_thread_has_the_bytes_of_single_commands(tmp_path: Path) -> None:
    with patch("cleaning.threads.ThreadPoolExecutor", side_effect=AssertionError("a second thread")):
        result = run_job(jobs(tmp_path)[3])
    edited = tmp_path / "edited.yaml"
    edited.write_text(OWN + "templates: {sweep: {speed_mm_s: 70}}\n")
    program, data = tmp_path / "single.wash", tmp_path / "single.json"
    assert washboard("plan", "tiny", edited, "-o", program).code == 0
    assert washboard("analyse", program, "tiny", "--recipe", edited, "--json", data).code == 1
    assert (result.program_sha256, result.analysis_sha256) == (sha256(program), sha256(data))


def test_a_value_that_the_recipe_refuses_is_the_error_of_its_runs(tmp_path: Path) -> None:
    for job in jobs(tmp_path)[6:]:
        result = run_job(job)
        assert "speed_mm_s: must be at most 10,000 mm/s" in result.error
        assert (result.job, dict(result.components)) == (job.key, {})


def test_a_recipe_that_changes_during_a_study_stops_it(tmp_path: Path) -> None:
    refused, job = jobs(tmp_path)[6], jobs(tmp_path)[3]
    assert run_job(refused).error
    (tmp_path / "own.yaml").write_text(OWN + "templates: {sweep: {speed_mm_s: 10}}\n")
    with pytest.raises(StudyError, match=r"own\.yaml: has changed since the study began"):
        run_job(job)
    (tmp_path / "own.yaml").unlink()
    with pytest.raises(StudyError, match="a worker cannot read it"):
        run_job(job)


def test_a_worker_of_another_version_is_refused(tmp_path: Path) -> None:
    with pytest.raises(StudyError, match=r"and the study 0\.0\.1"):
        run_job(replace(jobs(tmp_path)[0], version="0.0.1"))


@pytest.mark.slow
@pytest.mark.parametrize("at", [0, 3])
def test_a_recipe_that_cannot_be_read_for_a_moment_is_no_result(
    at: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    job, read, failing = jobs(tmp_path)[at], InputFile.read, iter([True, False, True])

    def read_or_fail(file: InputFile) -> bytes:
        if file.path.name == "own.yaml" and next(failing):
            raise file.error("cannot be read: Input/output error", file=file.path)
        return read(file)

    monkeypatch.setattr(InputFile, "read", read_or_fail)
    run_job_module._planned.cache_clear()
    with pytest.raises(StudyError, match=r"own\.yaml: a worker cannot read it: .*Input/output error"):
        run_job(job)
    assert not run_job(job).error


@pytest.mark.slow
def test_the_command_computes_writes_and_finds_all_done_the_next_time(tmp_path: Path) -> None:
    planned = jobs(tmp_path)
    first = washboard("study", tmp_path / "study.yaml", "-o", tmp_path / "out", "--workers", "1")
    assert first.code == 1, first.err  # the third speed is refused
    assert "3 combinations, 9 jobs computed now; 3 runs ended in an error" in first.out
    with (tmp_path / "out" / "runs.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["job"] for row in rows] == [job.key for job in planned]
    assert [bool(row["program_sha256"]) for row in rows] == [True, False, False] * 2 + [False] * 3
    before = contents(tmp_path / "out")
    (tmp_path / "out" / "runs.csv").unlink()
    second = washboard("study", tmp_path / "study.yaml", "-o", tmp_path / "out", "--workers", "1")
    assert "no jobs computed now" in second.out
    assert contents(tmp_path / "out") == before


FILM = """recipe: film
functions: {coat: {solution: paint, pressure_bar: 3.0, max_speed_mm_s: 150}}
nozzles: {gun: {pattern: radial, radius_mm: 20, at_mm: 60, flow_lpm: 0.003, at_bar: 3.0}}
classes: {}
templates: {passes: {path: slices, standoff_mm: 60, film: {thickness_um: 40, tolerance_um: 8}}}
limits: {acceleration_mm_s2: 2000, clearance_mm: 2, park_height_mm: 60}
sequence: [{function: coat, nozzle: gun, paths: [passes]}]
"""
"""Passes of its own lay a film: their numbers are not in the recipe."""


def part_jobs(folder: Path, recipe: str) -> list[Job]:
    trimesh.creation.box((20, 16, 8)).export(folder / "block.stl")
    (folder / "part.yaml").write_text("recipe: part\nextends: part-degrease\n")
    (folder / "film.yaml").write_text(FILM)
    study = (
        f"study: s\nboards: [block.stl]\nrecipes: [{recipe}]\ncell: ur5e-bench\ntolerances: {{samples: 2, deviations: "
    )
    (folder / "study.yaml").write_text(study + "{standoff_mm: {distribution: normal, sigma: 1}}}\n")
    return list(plan_study(folder / "study.yaml", no_progress).jobs())


@pytest.mark.slow
@pytest.mark.parametrize("recipe", ["part.yaml", "film.yaml"])
def test_a_part_is_studied_by_its_faces(tmp_path: Path, recipe: str) -> None:
    planned, deviated, _ = part_jobs(tmp_path, recipe)
    result, other = run_job(planned), run_job(deviated)
    program = tmp_path / "single.wash"
    assert washboard("plan", tmp_path / "block.stl", tmp_path / recipe, "-o", program).code == 0
    assert result.program_sha256 == sha256(program)
    assert set(result.components.values()) == {"clean"}
    assert len(result.components) == 6
    assert result.cell is not None
    assert result.seconds == other.seconds > 0.0
    assert (other.error, other.program_sha256, other.cell) == ("", "", None)
    assert set(other.components) == set(result.components)


def test_a_mesh_with_a_recipe_for_boards_is_no_part(tmp_path: Path) -> None:
    with pytest.raises(StudyError, match=r"study\.yaml:2: boards\[0\]: .*part-degrease"):
        part_jobs(tmp_path, "rinse-only")


def test_a_part_of_the_library_with_a_recipe_for_boards_is_the_error_of_its_runs(tmp_path: Path) -> None:
    (tmp_path / "study.yaml").write_text("study: s\nboards: [f-bracket]\nrecipes: [rinse-only]\n")
    (job,) = plan_study(tmp_path / "study.yaml", no_progress).jobs()
    assert "f-bracket is a part" in run_job(job).error
