"""Orders as six tools write them, with the usual mistakes: what is read, what is asked, and the plan."""

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from shutil import make_archive

import pytest
from command import washboard
from sample_boards.assemble import Place, Sample
from sample_boards.two_sided import TWO_SIDED
from sample_exports import agreement, gerber_layers, kicad_board, netlist

from boards.load import load_board

pytestmark = pytest.mark.slow

OMITTED = [each.name for each in TWO_SIDED.places if each.name.startswith("R")][:2]
FITTED = replace(TWO_SIDED, places=tuple(each for each in TWO_SIDED.places if each.name not in OMITTED))
LEAST = 0.95


def layers(folder: Path, top: str, bottom: str, edge: str, sample: Sample = TWO_SIDED) -> None:
    """Copper and edge under the names of a tool."""
    files = gerber_layers(sample)
    for old, new in (("card.gtl", top), ("card.gbl", bottom), ("card.gm1", edge)):
        file = folder / new
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(files[old])


def rows(line: Callable[[Place], str], *titles: str, side: str = "") -> str:
    return "\n".join([*titles, *(line(each) for each in TWO_SIDED.places if side in ("", each.side))]) + "\n"


def bill(mark: str, titles: tuple[str, str, str], left_out: str, otherwise: str) -> str:
    """A bill of materials that leaves two parts out."""
    return rows(lambda each: mark.join([each.name, each.value or "", left_out if each.name in OMITTED else otherwise]),
                mark.join(titles))  # fmt: skip


def kicad(folder: Path) -> None:
    """The table of the bottom has its x negated, as an option of KiCad has it."""
    (folder / "card.kicad_pcb").write_text(kicad_board(TWO_SIDED))
    (folder / "card-all.pos").write_text(
        rows(lambda each: f"{each.name} {each.value or '~'} {each.package} "
             f"{-each.x if each.side == 'bottom' else each.x:.4f} {each.y:.4f} {each.turn_deg:.4f} {each.side}",
             "### Footprint positions ###", "## Unit = mm, Angle = deg.", "# Ref Val Package PosX PosY Rot Side")
    )  # fmt: skip
    (folder / "card.csv").write_text(bill(",", ("Reference", "Value", "DNP"), "DNP", ""))


def altium(folder: Path) -> None:
    """In mil from another origin, with lines above the titles, and an older board beside it."""
    layers(folder / "Gerber", "card.GTL", "card.GBL", "card.GM1")
    layers(folder / "Old", "card.GTL", "card.GBL", "card.GM1")

    def line(each: Place) -> str:
        return (f'"{each.name}","{each.value or ""}","{each.side.title()}Layer","{each.package}",'
                f'"{(each.x + 50) / 0.0254:.3f}","{(each.y + 25) / 0.0254:.3f}","{each.turn_deg:g}",""')  # fmt: skip

    (folder / "Pick Place for card.csv").write_text(
        rows(line, "Altium Designer Pick and Place Locations", "C:\\jobs\\card.PcbDoc", "", "Units used: mil", "",
             '"Designator","Comment","Layer","Footprint","Center-X(mil)","Center-Y(mil)","Rotation","Description"')
    )  # fmt: skip
    (folder / "BOM.txt").write_text(bill("\t", ("Designator", "Comment", "Fitted"), "Not Fitted", "Fitted"))


def fusion(folder: Path) -> None:
    """A file a side without titles; some resistors are counted from another quarter."""
    layers(folder / "GerberFiles", "copper_top.gbr", "copper_bottom.gbr", "profile.gbr")
    for side, name in (("top", "front"), ("bottom", "back")):
        (folder / f"PnP_card_{name}.txt").write_text(
            rows(lambda each: f"{each.name} {each.x:.2f} {each.y:.2f} "
                 f"{each.turn_deg + 90 * ('R_0805' in each.package):g} {each.value or '-'} {each.package}", side=side)
        )  # fmt: skip
    (folder / "BOM.csv").write_text(bill(";", ("Parts", "Value", "Populate"), "no", "yes"))


def easyeda(folder: Path) -> None:
    """The sides are swapped, and the layers are packed once more."""
    layers(folder / "packed", "Gerber_TopLayer.GTL", "Gerber_BottomLayer.GBL", "Gerber_BoardOutlineLayer.GKO")
    make_archive(str(folder / "Gerber_card"), "zip", folder / "packed")
    for file in (folder / "packed").iterdir():
        file.unlink()
    (folder / "packed").rmdir()
    letter = {"top": "B", "bottom": "T"}
    text = rows(lambda each: f"{each.name}\t{each.package}\t{each.x:.3f}mm\t{each.y:.3f}mm\t{letter[each.side]}\t"
                f"{each.turn_deg:g}",
                "Designator\tFootprint\tMid X\tMid Y\tLayer\tRotation")  # fmt: skip
    (folder / "PickAndPlace_card.csv").write_bytes(text.encode("utf-16"))
    (folder / "BOM_card.csv").write_bytes(bill("\t", ("Designator", "Comment", "DNP"), "yes", "").encode("utf-16"))


def allegro(folder: Path) -> None:
    """In mil, without a side of the board in words, turns of the bottom from below, a netlist beside it."""
    layers(folder / "art", "TOP.art", "BOTTOM.art", "OUTLINE.art")
    (folder / "card.ipc").write_text(netlist(TWO_SIDED))

    def line(each: Place) -> str:
        turn = (180.0 - each.turn_deg) % 360.0 if each.side == "bottom" else each.turn_deg
        mirror = "m" if each.side == "bottom" else " "
        return f"{each.name} ! {each.x / 0.0254:.2f} ! {each.y / 0.0254:.2f} ! {turn:g} ! {mirror} ! {each.package} !"

    (folder / "place_txt.txt").write_text(rows(line, "UUNITS = MILS", "$END"))
    (folder / "bom.rpt").write_text(bill("|", ("RefDes", "Value", "Notes DNP"), "x", "").replace("Notes DNP", "DNP"))


def bare(folder: Path) -> None:
    """In German with decimal commas, a file a side, the bottom as seen from below, in inches that a title calls mm."""
    layers(folder, "Lage1.gbr", "Lage2.gbr", "Rand.gbr")
    x0, _, x1, _ = (min(x for x, _ in TWO_SIDED.outline), 0, max(x for x, _ in TWO_SIDED.outline), 0)
    for side, name in (("top", "Oberseite"), ("bottom", "Unterseite")):

        def line(each: Place) -> str:
            x = x0 + x1 - each.x if each.side == "bottom" else each.x
            places = (f"{value / 25.4:.6f}".replace(".", ",") for value in (x, each.y))
            return ";".join([each.name, each.package, *places, f"{each.turn_deg:g}".replace(".", ",")])

        text = rows(line, "Bauteil;Gehäuse;X-Position (mm);Y-Position (mm);Drehung", side=side)
        (folder / f"Bestückung {name}.csv").write_bytes(text.encode("cp1252"))
    (folder / "Stückliste.csv").write_bytes(
        bill(";", ("Bauteil", "Wert", "Bestückt"), "nein", "ja").encode("cp1252"))  # fmt: skip


TOOLS: dict[str, tuple[Callable[[Path], None], tuple[str, ...], tuple[str, str]]] = {
    "KiCad": (kicad, ("mirrored in x",), ("", "")),
    "Altium": (altium, ("shifted by (-50.000, -25.000) mm",), ("holds 2 boards: Gerber, Old", "board: Gerber\n")),
    "Fusion": (fusion, ("Turns are counted as the pads settle it",), ("", "")),
    "EasyEDA": (easyeda, ("statements on side contradict others",), ("", "")),
    "Allegro": (allegro, ("those of the bottom as seen from below",), ("", "")),
    "bare": (bare, ("are read as inch, not as mm (title)", "The positions of the bottom in Bestückung ",
                    "is read as the copper of the top, which nothing states"), ("", "")),
}  # fmt: skip
"""By tool: what writes the order, what is noted, and what is asked with its answer."""


def sources(text: str) -> Iterator[str]:
    yield from re.findall(r"parts table|netlist|layer", text)


@pytest.mark.parametrize("tool", TOOLS)
def test_an_order_with_its_mistakes_becomes_the_board_and_a_plan(tmp_path: Path, tool: str) -> None:
    write, noted, (asked, answer) = TOOLS[tool]
    (tmp_path / "order").mkdir()
    write(tmp_path / "order")
    order = Path(make_archive(str(tmp_path / "order"), "zip", tmp_path / "order"))
    if asked:
        shown = washboard("board", "show", order)
        assert asked in " ".join(shown.out.split())
        refused = washboard("plan", order, "-o", tmp_path / "a.wash")
        assert refused.code == 2
        assert not (tmp_path / "a.wash").exists()
        (tmp_path / "order.columns.yaml").write_text(answer)
    (tmp_path / "right.kicad_pcb").write_text(kicad_board(FITTED))
    right, board = load_board(tmp_path / "right.kicad_pcb"), load_board(order)
    shares = agreement(FITTED, right, board)
    assert {key: share for key, share in shares.items() if share < LEAST and key != "plan"} == {}
    assert not {*OMITTED} & {each.name for each in board.components}
    messages = [each.message for each in board.findings]
    for words in noted:
        assert any(words in message for message in messages), words
    assert not [each.message for each in board.findings if each.severity == "error"]
    shown = washboard("board", "show", order)
    assert shown.code == 0
    assert {*sources(shown.out)} >= {"parts table"}
    planned = washboard("plan", order, "-o", tmp_path / "a.wash")
    assert (planned.code, (tmp_path / "a.wash").exists()) == (0, True), planned.err
