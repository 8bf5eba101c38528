import os

import pytest
from ecad_writers import EcadBoard, EcadPart, odb, write_folder
from hypothesis import given, settings
from hypothesis import strategies as st
from made_study import write_made_study
from shapely import box

from boards.load import board_library
from boards.part.sources import part_library
from boards.workpiece import load_workpiece
from recipes.load import load_recipe, recipe_library
from specs.output_file import OutputError
from webui.page.project import ProjectError, open_project

SAMPLES = (*board_library(), *part_library())


@pytest.fixture
def outside(tmp_path):
    folder = tmp_path / "outside"
    folder.mkdir()
    (folder / "secret.tri").write_text("secret")
    return folder


@pytest.fixture
def project(tmp_path, outside):
    folder = tmp_path / "project"
    (folder / "deep" / "er").mkdir(parents=True)
    (folder / "board.step").write_text("a")
    (folder / "recipe.yaml").write_text("b")
    (folder / "deep" / "er" / "old.TRI.gz").write_text("c")
    return open_project(folder)


def test_folder_must_be_there(tmp_path):
    with pytest.raises(ProjectError, match="no such folder"):
        open_project(tmp_path / "missing")
    (tmp_path / "file").write_text("")
    with pytest.raises(ProjectError, match="no such folder"):
        open_project(tmp_path / "file")


def test_samples_come_first_then_the_folders_files(project):
    assert project.workpieces() == [*SAMPLES, "board.step", "deep/er/old.TRI.gz"]
    assert project.recipes() == [*recipe_library(), "recipe.yaml"]
    assert project.locate("deep/er/old.TRI.gz").read_text() == "c"


def test_own_workpieces_are_those_of_the_folder(project):
    assert project.own_workpieces() == ["board.step", "deep/er/old.TRI.gz"]
    assert open_project(project.folder / "deep").own_workpieces() == ["er/old.TRI.gz"]


def test_recipes_are_described_by_their_own_words_or_their_mistake(project):
    assert project.describe_recipe("dry-only") == load_recipe("dry-only").description
    assert "recipe.yaml" in project.describe_recipe("recipe.yaml")
    (project.folder / "plain.yaml").write_text("extends: dry-only\ndescription: ''\n")
    assert project.describe_recipe("plain.yaml") == "It has no description."


def test_links_hidden_files_devices_and_names_that_are_no_text_are_not_listed(project, outside):
    (project.folder / "link.tri").symlink_to(outside / "secret.tri")
    (project.folder / "way").symlink_to(outside)
    (project.folder / ".hidden.tri").write_text("")
    (project.folder / ".cache").mkdir()
    (project.folder / ".cache" / "x.tri").write_text("")
    (project.folder / "folder.tri").mkdir()
    (project.folder / "line\nbreak.tri").write_text("")
    os.mkfifo(project.folder / "pipe.tri")
    (project.folder / os.fsdecode(b"broken-\xff.tri")).write_text("")
    assert project.workpieces() == [*SAMPLES, "board.step", "deep/er/old.TRI.gz"]


def test_search_ends_in_deep_and_in_crowded_folders(project):
    deep = project.folder / "1/2/3/4/5/6"
    deep.mkdir(parents=True)
    (deep / "far.tri").write_text("")
    crowd = project.folder / "crowd"
    crowd.mkdir()
    for number in range(600):
        (crowd / f"{number}.stl").write_text("")
    listed = project.workpieces()
    assert "1/2/3/4/5/6/far.tri" not in listed
    assert len(listed) - len(SAMPLES) == 500
    assert listed[len(SAMPLES)] == "board.step"


@pytest.mark.parametrize(
    "name",
    [
        "",
        ".",
        "..",
        "/",
        "../outside/secret.tri",
        "deep/../../outside/secret.tri",
        "deep/../board.step",
        "/etc/passwd",
        "//etc/passwd",
        "~/.ssh/id_rsa/..",
        ".git/config",
        "deep/.hidden.tri",
        "board.step\0.yaml",
        "board\n.step",
        "\x1b[2Jboard.step",
        "\udcff.step",
        "x" * 300 + ".step",
        "x" * 5000,
        "deep",
        "link.tri",
        "way/secret.tri",
        "circle.tri",
        "pipe.tri",
        "null.tri",
    ],
)
def test_names_that_lead_elsewhere_are_refused(project, outside, name):
    (project.folder / "link.tri").symlink_to(outside / "secret.tri")
    (project.folder / "way").symlink_to(outside)
    (project.folder / "circle.tri").symlink_to("circle.tri")
    (project.folder / "null.tri").symlink_to("/dev/null")
    os.mkfifo(project.folder / "pipe.tri")
    with pytest.raises(ProjectError) as caught:
        project.locate(name)
    assert len(str(caught.value)) < 700
    assert str(caught.value).isprintable()


@pytest.mark.slow
@settings(max_examples=200)
@given(name=st.text(max_size=30) | st.text(alphabet="./\\~ab\0\n", max_size=12))
def test_whatever_is_located_lies_inside(tmp_path_factory, name):
    project = open_project(tmp_path_factory.getbasetemp())
    try:
        path = project.locate(name)
    except ProjectError:
        return
    assert path.is_relative_to(project.folder)
    assert path != project.folder


def test_links_that_stay_inside_may_be_used(project):
    (project.folder / "same.step").symlink_to("board.step")
    assert project.locate("same.step") == project.folder / "board.step"


@pytest.mark.parametrize("name", ["my board (rev. 2).STEP", "Gehäuse+Träger@2.tri.gz", "基板.kicad_pcb", "a.stl"])
def test_uploads_are_kept_under_their_names(project, name):
    assert project.store(name, b"content").name == name
    assert (project.folder / name).read_bytes() == b"content"
    assert name in project.workpieces()


def test_accents_sent_apart_are_joined(project):
    assert project.store("Gera\u0308t.stl", b"1").name == "Gerät.stl"


@pytest.mark.parametrize(
    "name",
    [
        "",
        ".step",
        "../x.step",
        "deep/x.step",
        "/tmp/x.step",
        "deep\\x.step",
        "x\0.step",
        "x\n.step",
        "-rf.step",
        "\u202epets.step",
        "\ud800.step",
        "$(reboot).step",
        "<b>.step",
        "x" * 250 + ".step",
        "ä" * 120 + ".step",
        "x.exe",
        "x.yaml",
        "x",
    ],
)
def test_uploads_of_odd_names_are_refused_and_nothing_is_written(project, name):
    before = sorted(os.walk(project.folder))
    with pytest.raises(ProjectError) as caught:
        project.store(name, b"content")
    assert str(caught.value).isprintable()
    assert sorted(os.walk(project.folder)) == before


def test_huge_uploads_are_refused(project):
    class Huge(bytes):
        def __len__(self):
            return 200_000_001

    with pytest.raises(ProjectError, match="200 MB are too many"):
        project.store("huge.step", Huge())
    assert not (project.folder / "huge.step").exists()


def test_what_is_there_stays(project):
    assert project.store("board.step", b"a").name == "board.step"
    assert project.store("board.step", b"other").name == "board-2.step"
    assert project.store("board.step", b"other").name == "board-2.step"
    assert project.store("rev.1.tri.gz", b"x").name == "rev.1.tri.gz"
    assert project.store("rev.1.tri.gz", b"y").name == "rev.1-2.tri.gz"
    assert (project.folder / "board.step").read_bytes() == b"a"


def test_uploads_do_not_follow_links_and_do_not_read_devices(project, outside):
    (project.folder / "new.tri").symlink_to(outside / "new.tri")
    (project.folder / "secret.tri").symlink_to(outside / "secret.tri")
    os.mkfifo(project.folder / "pipe.tri")
    assert project.store("new.tri", b"x").name == "new-2.tri"
    assert project.store("secret.tri", b"secret").name == "secret-2.tri"
    assert project.store("pipe.tri", b"x").name == "pipe-2.tri"
    assert sorted(entry.name for entry in outside.iterdir()) == ["secret.tri"]


def test_full_or_lost_folder_says_so(project):
    for path in sorted(project.folder.rglob("*"), reverse=True):
        path.rmdir() if path.is_dir() else path.unlink()
    project.folder.rmdir()
    assert project.workpieces() == list(SAMPLES)
    with pytest.raises(OutputError, match="cannot be written"):
        project.store("x.step", b"x")


def test_discarding_removes_what_was_stored_and_nothing_outside(project, outside):
    stored = project.store("broken.step", b"x")
    assert stored.fresh
    assert not project.store("broken.step", b"x").fresh
    project.discard(stored.name)
    assert not (project.folder / "broken.step").exists()
    project.discard("broken.step")
    with pytest.raises(ProjectError):
        project.discard("../outside/secret.tri")
    assert (outside / "secret.tri").exists()


@pytest.mark.slow
def test_studies_are_listed_by_the_head_of_their_table_and_their_results_are_not_walked(project):
    write_made_study(project.folder / "deep" / "margins")
    (project.folder / "deep" / "margins" / "results" / "ab" / "recipe.yaml").write_text("recipe: x\n")
    (project.folder / "results").mkdir()
    (project.folder / "results" / "mine.yaml").write_text("recipe: mine\n")
    (project.folder / "parts.csv").write_text("component,package\n")
    assert project.studies() == ["deep/margins/runs.csv"]
    assert project.recipes() == [*recipe_library(), "recipe.yaml", "results/mine.yaml"]


def test_what_a_study_names_is_found_from_its_table_on_up_and_not_outside(project, outside):
    table = "deep/margins/runs.csv"
    assert project.find_named("board.step", table) == "board.step"
    assert project.find_named("er/old.TRI.gz", table) == "deep/er/old.TRI.gz"
    assert project.find_named(str(project.folder / "recipe.yaml"), table) == "recipe.yaml"
    (project.folder / "deep" / "board.step").write_text("nearer")
    assert project.find_named("board.step", table) == "deep/board.step"
    for name in ("../outside/secret.tri", "../../../outside/secret.tri", str(outside / "secret.tri"), "none", "", "\n"):
        with pytest.raises(ProjectError):
            project.find_named(name, table)


def test_odb_jobs_are_listed_as_folders_and_their_files_are_not(project, outside):
    job = odb(EcadBoard(box(0, 0, 30, 20), 1.6, (EcadPart("U1", 9, 9, 4, 3, 1, 0, "top"),)))
    write_folder({**job, "steps/card/notes.tri": "of the job"}, project.folder / "deep" / "card")
    assert project.workpieces() == [*SAMPLES, "board.step", "deep/er/old.TRI.gz", "deep/card/"]
    assert project.workpiece_source("deep/card/") == project.folder / "deep" / "card"
    assert load_workpiece(project.workpiece_source("deep/card/")).components[0].name == "U1"
    (project.folder / "way").symlink_to(outside)
    for name in ("way/", "../outside/", f"{outside}/", "board.step/", "none/", "/", ".."):
        with pytest.raises(ProjectError):
            project.workpiece_source(name)
