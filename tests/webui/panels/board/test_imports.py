"""Uploads become boards, or a message and nothing else."""

import numpy as np
import pytest
from ecad_writers import EcadBoard, EcadPart, odb, write_tgz, write_zip
from shapely import box

from boards.board import Part
from boards.errors import BoardError
from boards.load import board_library, load_board
from recipes.load import load_recipe
from webui.page.project import ProjectError, open_project
from webui.panels.board.board import import_workpiece, join_table
from webui.threads.threads import CancelledError

TINY = board_library()["tiny"]
RECIPE = load_recipe("rinse-only")


def quiet(_what, _done):
    pass


@pytest.fixture
def project(tmp_path):
    return open_project(tmp_path)


def test_an_upload_is_kept_and_read(project):
    loaded = import_workpiece(project, "mine.tri", TINY.read_bytes(), RECIPE, quiet)
    assert loaded.name == "mine.tri"
    assert loaded.workpiece.sha256 == load_board(TINY).sha256
    assert "mine.tri" in project.workpieces()


@pytest.mark.parametrize("name", ["x.tri", "x.tri.gz", "x.step", "x.glb", "x.stl", "x.kicad_pcb", "x.emn", "x.ply"])
@pytest.mark.parametrize("content", [b"", b"\0" * 300, b"board-tri 1\nunits mm\nobjects 1\n", bytes(range(256)) * 8])
def test_broken_uploads_are_refused_and_not_kept(project, name, content):
    with pytest.raises(BoardError):
        import_workpiece(project, name, content, RECIPE, quiet)
    assert list(project.folder.iterdir()) == []


@pytest.mark.parametrize("name", ["scan.XYZ", "scan.txt"])
def test_a_cloud_of_points_is_a_part_whatever_the_recipe(project, name):
    x, y = (each.ravel() for each in np.meshgrid(np.arange(0.0, 60), np.arange(0.0, 40)))
    cloud = "# x y z\n" + "".join(f"{a:.1f}; {b:.1f}; {a * b / 300:.3f}\n" for a, b in zip(x, y, strict=True))
    (project.folder / "notes.txt").write_text("1. measure\n2 of 3 are done\n")
    loaded = import_workpiece(project, name, cloud.encode(), RECIPE, quiet)
    assert isinstance(loaded.workpiece, Part)
    assert [face.name for face in loaded.workpiece.served] == ["face-1"]
    assert name in project.workpieces()
    assert "notes.txt" not in project.workpieces()


@pytest.mark.parametrize("content", [b"", b"\0" * 300, b"read me first\n", b"1 2 3\n4 5\n", bytes(range(256)) * 8])
def test_texts_that_are_no_clouds_are_refused_and_not_kept(project, content):
    with pytest.raises(BoardError):
        import_workpiece(project, "scan.txt", content, RECIPE, quiet)
    assert list(project.folder.iterdir()) == []


def test_a_cancelled_upload_is_not_kept(project):
    def cancelled(_what, done):
        if done > 0.5:
            raise CancelledError

    with pytest.raises(CancelledError):
        import_workpiece(project, "mine.tri", TINY.read_bytes(), RECIPE, cancelled)
    assert list(project.folder.iterdir()) == []


def test_what_was_there_before_stays_when_it_cannot_be_read(project):
    (project.folder / "broken.tri").write_bytes(b"nothing")
    with pytest.raises(BoardError):
        import_workpiece(project, "broken.tri", b"nothing", RECIPE, quiet)
    assert (project.folder / "broken.tri").read_bytes() == b"nothing"


def test_a_parts_table_is_joined(project):
    name = load_board(TINY).components[0].name
    table = f"Ref,Package,Value\n{name},SOIC-8_odd,47k\n".encode()
    board = join_table("Parts.CSV", table, lambda path: load_board(TINY, path))
    joined = next(each for each in board.components if each.name == name)
    assert (joined.package, joined.value) == ("SOIC-8_odd", "47k")


@pytest.mark.parametrize(
    ("name", "content", "error"),
    [
        ("parts.ods", b"PK", ProjectError),
        ("parts.xlsx", b"PK", BoardError),
        ("../../x", b"", ProjectError),
        ("p.csv", b"\0\xff\xfe", BoardError),
    ],
)
def test_what_is_no_parts_table_is_refused(name, content, error):
    with pytest.raises(error):
        join_table(name, content, lambda path: load_board(TINY, path))


@pytest.mark.parametrize(("name", "write"), [("card.tgz", write_tgz), ("card.zip", write_zip)])
def test_an_odb_job_is_imported_as_an_archive(tmp_path, name, write):
    write(odb(EcadBoard(box(0, 0, 30, 20), 1.6, (EcadPart("U1", 9, 9, 4, 3, 1, 0, "top"),))), tmp_path / name)
    folder = tmp_path / "project"
    folder.mkdir()
    project = open_project(folder)
    loaded = import_workpiece(project, name, (tmp_path / name).read_bytes(), RECIPE, quiet)
    assert loaded.name == name in project.workpieces()
    assert [each.name for each in loaded.workpiece.components] == ["U1"]
