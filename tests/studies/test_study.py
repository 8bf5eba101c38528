"""Study files: what is wrong with one is stated in one sentence, with file, line and YAML path."""

from pathlib import Path

import pytest
from command import washboard

from specs.progress import no_progress
from studies.errors import StudyError
from studies.planned_study import plan_study

HEAD = "study: speeds\nboards: [tiny]\nrecipes: [rinse-only]\n"
SPEED = "path: templates.sweep.speed_mm_s"


def written(folder: Path, text: str) -> Path:
    file = folder / "study.yaml"
    file.write_text(text)
    return file


BAD = {
    "typo": ("study: x\nbords: [tiny]\nrecipes: [rinse-only]\n", ":2: bords: unknown key; did you mean 'boards'?"),
    "NaN": (HEAD + f"variables: [{{{SPEED}, values: [50, .nan]}}]", ":4: variables[0].values[1]: must be a finite"),
    "NaN in a range": (HEAD + f"variables: [{{{SPEED}, low: .nan, high: 9, steps: 3}}]", ":4: variables[0].low: must"),
    "endless name": (
        f"study: x\nboards:\n  - {'n' * 300}\nrecipes: [rinse-only]\n",
        ":3: boards[0]: File name too long",
    ),
    "unknown board": ("study: x\nboards:\n  - tinny\nrecipes: [rinse-only]\n", ":3: boards[0]: tinny: no board of"),
    "unknown recipe": (
        "study: x\nboards: [tiny]\nrecipes: [rinse-onl]\n",
        ":3: recipes[0]: no recipe 'rinse-onl'. Did",
    ),
    "unknown set": (HEAD + "parameters: [defalt]", ":4: parameters[0]: no parameter set 'defalt'. Did you mean"),
    "unknown cell": (HEAD + "cell: ur5e-benc", ":4: cell: no cell 'ur5e-benc'. Did you mean 'ur5e-bench'?"),
    "empty grid": (HEAD + f"variables: [{{{SPEED}, values: []}}]", ":4: variables[0].values: needs at least 1, has 0"),
    "no board": ("study: x\nboards: []\nrecipes: [rinse-only]\n", ":2: boards: needs at least 1, has 0"),
    "a billion jobs": (
        HEAD + "variables:\n" + "".join(f"  - {{path: templates.{k}, low: 1, high: 2, steps: 1000}}\n" for k in "abc"),
        ":1: the study has 1,000,000,000 jobs; at most 100,000 can be done",
    ),
    "no such template": (
        HEAD + "variables: [{path: templates.swep.speed_mm_s, values: [5]}]",
        ":4: variables[0].path: the recipe rinse-only has no such value: nothing is at templates.swep; did you mean",
    ),
    "no such key": (
        HEAD + "variables: [{path: templates.sweep.sped_mm_s, values: [5]}]",
        ":4: variables[0].path: the recipe rinse-only has no such value: did you mean 'speed_mm_s'?",
    ),
    "no steps": (
        HEAD + f"variables: [{{{SPEED}, low: 1, high: 9}}]",
        "templates.sweep.speed_mm_s needs steps in a grid",
    ),
    "varied twice": (HEAD + f"variables: [{{{SPEED}, values: [5]}}, {{{SPEED}, values: [6]}}]", "is varied twice"),
    "unknown tolerance": (
        HEAD + "tolerances: {deviations: {standof_mm: {distribution: uniform, low: 0, high: 1}}}",
        ":4: tolerances.deviations.standof_mm: 'standof_mm' is not known; did you mean 'standoff_mm'?",
    ),
    "no tolerance any more": (
        HEAD + "tolerances: {deviations: {pressure_pct: {distribution: normal, sigma: 20}}}",
        ":4: tolerances: pressure_pct reaches 80; at most 60 is a tolerance",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_study_is_refused_with_its_place(name: str, tmp_path: Path) -> None:
    text, message = BAD[name]
    file = written(tmp_path, text)
    with pytest.raises(StudyError) as caught:
        plan_study(file, no_progress)
    assert str(caught.value).startswith(f"{file}:")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_command_refuses_with_one_line_and_exit_code_2(tmp_path: Path) -> None:
    done = washboard("study", written(tmp_path, BAD["typo"][0]), "-o", tmp_path / "out")
    assert (done.code, done.out, done.err.count("\n")) == (2, "", 1)
    assert not (tmp_path / "out").exists()
    missing = washboard("study", tmp_path / "none.yaml", "-o", tmp_path / "out")
    assert missing.code == 2
    assert "none.yaml: no such file" in missing.err


def test_files_of_a_study_are_looked_for_beside_it(tmp_path: Path) -> None:
    (tmp_path / "own.yaml").write_text("recipe: own\nextends: rinse-only\n")
    planned = plan_study(written(tmp_path, "study: x\nboards: [tiny]\nrecipes: [own.yaml]\n"), no_progress)
    assert planned.recipes[0].file == str(tmp_path / "own.yaml")


def test_names_of_the_library_come_before_folders_beside_the_study(tmp_path: Path) -> None:
    for name in ("tiny", "rinse-only", "default"):  # such as a study's output
        (tmp_path / name).mkdir()
    planned = plan_study(written(tmp_path, HEAD), no_progress)
    assert Path(planned.boards[0].file).name == "tiny.tri"


def test_a_value_that_the_recipe_has_is_the_job_without_it(tmp_path: Path) -> None:
    plain = plan_study(written(tmp_path, HEAD), no_progress)
    varied = plan_study(written(tmp_path, HEAD + f"variables: [{{{SPEED}, values: [60, 61]}}]"), no_progress)
    own = varied.own[0][0]
    keys = {case.point[0]: next(varied.jobs_of(case)).key for case in varied.cases()}
    (key,) = [job.key for job in plain.jobs()]
    assert own == 60
    assert keys[60] == key != keys[61]
