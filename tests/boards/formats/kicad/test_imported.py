"""Boards that KiCad imports: through its command line, here a stand-in; and one sentence where there is none."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from command import washboard
from waiting import wait_for

from boards.errors import BoardError
from boards.load import load_board

BOARD = Path(__file__).parents[3] / "fuzz" / "corpus" / "KiCad" / "v9.kicad_pcb"
FOREIGN = {
    "card.PcbDoc": b"\xd0\xcf\x11\xe0 Altium",
    "card.asc": b"!PADS-POWERPCB-V9.5-MILS! DESIGN DATABASE ASCII FILE 1.0\n*PCB*\n",
    "card.json": b'{\n  "head": {\n    "docType": "3",\n    "editorVersion": "6.5"\n  },\n  "shape": []\n}\n',
    "card.cpa": b'(CADSTARPCB\n  (HEADER (FORMAT "PCB"))\n',
    "card.txt": b'(CADSTARPCB\n  (HEADER (FORMAT "PCB"))\n',
}


def stand_in(folder: Path, monkeypatch: pytest.MonkeyPatch, script: str) -> None:
    program = folder / "bin" / "kicad-cli"
    program.parent.mkdir()
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{program.parent}{os.pathsep}{os.environ['PATH']}")


@pytest.mark.parametrize("name", FOREIGN)
def test_what_kicad_makes_of_a_board_is_read(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The stand-in takes the words that KiCad 10 documents, and gives a board of KiCad."""
    stand_in(tmp_path, monkeypatch, f'[ "$1 $2 $3" = "pcb import --output" ] && [ -f "$5" ] && cp {BOARD} "$4"')
    (tmp_path / name).write_bytes(FOREIGN[name])
    board = load_board(tmp_path / name)
    assert board.name == "card"
    assert [each.name for each in board.components] == [each.name for each in load_board(BOARD).components]


@pytest.mark.parametrize("in_order", [False, True])
@pytest.mark.parametrize("name", FOREIGN)
def test_without_kicad_one_sentence_names_what_to_do(
    name: str, in_order: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    (tmp_path / name).write_bytes(FOREIGN[name])
    if in_order and name == "card.json":
        return  # in an order texts of this kind are not looked into
    with pytest.raises(BoardError) as caught:
        load_board(tmp_path if in_order else tmp_path / name)
    assert str(caught.value).startswith(str(tmp_path / name))
    assert "kicad-cli is not installed: install KiCad 10 or newer, or export the board as ODB++" in str(caught.value)
    assert str(caught.value).count(". ") == 0


def test_what_kicad_refuses_is_named_with_its_reason(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in(tmp_path, monkeypatch, 'echo "Unknown argument: import" >&2; exit 1')
    (tmp_path / "card.PcbDoc").write_bytes(FOREIGN["card.PcbDoc"])
    result = washboard("board", "show", tmp_path / "card.PcbDoc")
    assert result.code == 2
    assert "card.PcbDoc: kicad-cli does not import it (Unknown argument: import): use KiCad 10" in result.err


def test_a_board_that_a_failing_kicad_leaves_is_not_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in(tmp_path, monkeypatch, f'cp {BOARD} "$4"; echo "half of it" >&2; exit 1')
    (tmp_path / "card.PcbDoc").write_bytes(FOREIGN["card.PcbDoc"])
    with pytest.raises(BoardError, match=r"card\.PcbDoc: kicad-cli does not import it \(half of it\)"):
        load_board(tmp_path / "card.PcbDoc")


def test_a_fault_in_what_kicad_made_names_the_board(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in(tmp_path, monkeypatch, 'echo "(kicad_pcb (version 20240108))" > "$4"')
    (tmp_path / "card.PcbDoc").write_bytes(FOREIGN["card.PcbDoc"])
    with pytest.raises(BoardError, match=r"card\.PcbDoc: no board outline in the file"):
        load_board(tmp_path / "card.PcbDoc")


def test_in_an_order_gerber_files_come_before_a_board_that_needs_kicad(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    (tmp_path / "card.PcbDoc").write_bytes(FOREIGN["card.PcbDoc"])
    head = "%FSLAX46Y46*%\n%MOMM*%\n%ADD10C,0.1*%\nD10*\nG01*\n"
    (tmp_path / "b.gko").write_text(f"{head}X0Y0D02*\nX30000000D01*\nY20000000D01*\nX0D01*\nY0D01*\nM02*\n")
    board = load_board(tmp_path)
    assert [(each.name, each.kind) for each in board.sources][-1] == ("card.PcbDoc", "not read")


def test_kicad_is_bounded_and_ends_with_its_parent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in(tmp_path, monkeypatch, f"ulimit -v -t -f > {tmp_path}/bounds; echo $$ > {tmp_path}/pid; exec sleep 60")
    (tmp_path / "card.PcbDoc").write_bytes(FOREIGN["card.PcbDoc"])
    start = "from pathlib import Path\nfrom boards.load import load_board\nload_board(Path('card.PcbDoc'))\n"
    path = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen([sys.executable, "-c", start], cwd=tmp_path, env=path) as parent:
        wait_for(lambda: (tmp_path / "pid").is_file() and (tmp_path / "pid").read_text())
        parent.kill()
    assert "unlimited" not in (tmp_path / "bounds").read_text()
    child = Path("/proc", (tmp_path / "pid").read_text().strip(), "cmdline")
    wait_for(lambda: not child.exists() or not child.read_text())
