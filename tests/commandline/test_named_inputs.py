"""What inputs name is an input too, such as the board of a panel."""

from pathlib import Path

import pytest
from command import contents, washboard
from each_workpiece import write_inputs

IMPORTED = ("board", "import", "two.yaml", "-o", "small.tri")


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (IMPORTED, "small.tri"),
        ((*IMPORTED[:-1], "link.tri"), "link.tri"),
        ((*IMPORTED[:-1], "hard.tri"), "hard.tri"),
        (("operate", "two.wash", "--cell", "gantry", "--dry", "--log", "small.tri"), "small.tri"),
    ],
)
def test_what_an_input_names_is_not_written_over(
    words: tuple[str, ...], named: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_inputs(tmp_path)
    (tmp_path / "link.tri").symlink_to("small.tri")
    (tmp_path / "hard.tri").hardlink_to("small.tri")
    if "two.wash" in words:
        assert washboard("plan", "two.yaml", "brief.yaml", "-o", "two.wash").code == 0
        words = (*words, "--board", "two.yaml")
    before = contents(tmp_path)
    outcome = washboard(*words)
    assert (outcome.code, outcome.out) == (2, "")
    assert "it is read by this command" in outcome.err or "is to be written by this command" in outcome.err
    assert named in outcome.err or "small.tri" in outcome.err
    assert contents(tmp_path) == before


@pytest.mark.parametrize(
    "words",
    [
        ("plan", "small.tri", "child.yaml", "-o", "x.wash", "--picture", "x.svg", "--report", "brief.yaml.json"),
        ("tune", "small.tri", "child.yaml", "-o", "t.yaml", "--report", "brief.yaml.json", "--resume"),
        ("tune", "small.tri", "child.yaml", "-o", "f/t.yaml", "--front", "f"),
        ("tune", "small.tri", "child.yaml", "-o", "t.yaml", "--front", "t.yaml"),
        ("tune", "small.tri", "child.yaml", "--report", "f.json", "--front", "f.json"),
        ("tune", "small.tri", "child.yaml", "--front", "chosen"),
        ("tune", "small.tri", "front/front-1.yaml", "--front", "front"),
    ],
)
def test_outputs_that_inputs_name_or_that_meet_are_refused_before_the_work(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_inputs(tmp_path)
    (tmp_path / "brief.yaml.json").write_bytes((tmp_path / "brief.yaml").read_bytes())
    (tmp_path / "child.yaml").write_text("recipe: child\nextends: brief.yaml.json\n")
    for folder, name in (("f", ""), ("chosen", "front-chosen.yaml"), ("front", "front-1.yaml")):
        (tmp_path / folder).mkdir()
        if name:
            (tmp_path / folder / name).write_text("recipe: front-1\nextends: ../brief.yaml\n")
    before = contents(tmp_path)
    outcome = washboard(*words)
    assert (outcome.code, outcome.out) == (2, "")
    assert contents(tmp_path) == before
