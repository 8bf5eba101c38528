from pathlib import Path

import pytest
from command import contents

from reports.files.atomic_folder import write_files
from reports.files.atomic_write import OutputError

ONE = {"demo.mod": "MODULE demo\n"}
SOME = {"demo.pgf": "list\n", "demo.mod": "main\n", "demo_01.mod": "part\n"}


def test_one_file_is_written_where_it_is_asked_for(tmp_path: Path) -> None:
    assert write_files(tmp_path / "x.mod", ONE) == [tmp_path / "x.mod"]
    assert write_files(tmp_path, ONE) == [tmp_path / "demo.mod"]
    assert contents(tmp_path) == {"x.mod": b"MODULE demo\n", "demo.mod": b"MODULE demo\n"}


def test_several_files_make_a_folder_and_replace_their_like(tmp_path: Path) -> None:
    out = tmp_path / "demo"
    longer = {**SOME, "demo_02.mod": "more\n"}
    assert write_files(out, longer) == [out / name for name in longer]
    write_files(out, SOME)
    assert contents(tmp_path) == {f"demo/{name}": text.encode() for name, text in SOME.items()}


@pytest.mark.parametrize("name", ["thesis.txt", "demo.mod/x", "demo_1.bak"])
def test_a_folder_with_other_things_is_left_alone(tmp_path: Path, name: str) -> None:
    other = tmp_path / name
    other.parent.mkdir(exist_ok=True)
    other.write_text("mine")
    before = contents(tmp_path)
    with pytest.raises(OutputError, match="holds something else"):
        write_files(tmp_path, SOME)
    assert contents(tmp_path) == before


def test_several_files_do_not_go_into_a_file_or_into_nowhere(tmp_path: Path) -> None:
    file = tmp_path / "demo"
    file.write_text("mine")
    with pytest.raises(OutputError, match="Name a folder"):
        write_files(file, SOME)
    with pytest.raises(OutputError, match="no folder"):
        write_files(tmp_path / "no" / "where", SOME)
    assert contents(tmp_path) == {"demo": b"mine"}


def test_after_a_failure_the_old_files_stand(tmp_path: Path) -> None:
    out = tmp_path / "demo"
    write_files(out, SOME)
    before = contents(tmp_path)
    with pytest.raises(OutputError):
        write_files(out, {**SOME, "demo_03.mod": "größe"})
    assert contents(tmp_path) == before
