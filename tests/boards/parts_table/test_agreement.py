"""Sample boards as Gerber files with a centroid, compared with KiCad's files of the same boards."""

from dataclasses import replace
from pathlib import Path
from shutil import make_archive

import pytest
from sample_boards.assemble import Sample
from sample_boards.radio_stick import RADIO_STICK
from sample_boards.sensor_hub import SENSOR_HUB
from sample_boards.two_sided import TWO_SIDED
from sample_exports import agreement, kicad_board, write_order

from boards.load import load_board

LEAST = 0.95


def check(sample: Sample, order: Path, folder: Path) -> None:
    (folder / "card.kicad_pcb").write_text(kicad_board(sample))
    right, found = load_board(folder / "card.kicad_pcb"), load_board(order)
    assert len(right.components) == len(sample.places)
    shares = agreement(sample, right, found)
    assert {key: share for key, share in shares.items() if share < LEAST} == {}
    assert "turn" not in {each.about for each in found.contradictions}


@pytest.mark.parametrize("sample", [SENSOR_HUB, RADIO_STICK, TWO_SIDED], ids=lambda each: each.name)
@pytest.mark.parametrize("is_named", [True, False], ids=["netlist", "bare"])
def test_an_order_has_the_components_of_the_board_it_is_of(tmp_path: Path, sample: Sample, is_named: bool) -> None:
    check(sample, write_order(sample, tmp_path / "order", is_named=is_named), tmp_path)


@pytest.mark.parametrize("sample", [RADIO_STICK, TWO_SIDED], ids=lambda each: each.name)
def test_so_it_has_in_inches_with_turns_from_below_in_an_archive(tmp_path: Path, sample: Sample) -> None:
    order = write_order(sample, tmp_path / "order", "INCH", from_below=True)
    check(sample, Path(make_archive(str(tmp_path / "order"), "zip", order)), tmp_path)


@pytest.mark.parametrize("turn", [0.0, 90.0, 30.0])
@pytest.mark.parametrize("side", ["top", "bottom"])
def test_the_body_of_a_transistor_lies_between_its_leads(tmp_path: Path, turn: float, side: str) -> None:
    """Its family states 2.9 x 1.3 mm, whichever way a library draws it."""
    one = next(each for each in SENSOR_HUB.places if each.package == "SOT-23")
    sample = replace(SENSOR_HUB, places=tuple(
        replace(one, name=f"Q{n}", x=20.0 + 8.0 * n, y=20.0, turn_deg=turn, side=side) for n in (1, 2, 3)))  # fmt: skip
    check(sample, write_order(sample, tmp_path / "order"), tmp_path)
