"""What a program cleans, as tables: the components of a board, the faces of a part and the cards of one."""

from collections.abc import Sequence

from cleaning.part_faces import FaceVerdict
from cleaning.verdicts.results import Part, deciding_judgement, outcome
from cleaning.verdicts.rules import VERDICTS
from reports.cards.cleaning import cleaned_face_card
from reports.tables.table import Column, Table, Text
from webui.cards.finding_list import source_words
from webui.theme.html import card_html, listing_html, quiet_html

_COLUMNS = (
    Column("part", width="18%"),
    Column("verdict", width="28%"),
    Column("because", width="34%"),
    Column("residue", "right", width="20%"),
)
_VERDICTS = (
    Column("face", width="30%"),
    Column("verdict", width="26%"),
    Column("held", "right", width="22%"),
    Column("least", "right", width="22%"),
)


def parts_html(parts: Sequence[Part], selected: str) -> str:
    """The parts as a table, the selected one marked."""
    if not parts:
        return quiet_html("The board has no parts.")
    rows = [
        (
            part.component, Text(outcome(part), tone=outcome(part)), deciding_judgement(part).name,
            "" if part.residue is None else f"{100 * part.residue:.1f} %",
        )
        for part in parts
    ]  # fmt: skip
    return listing_html(Table(_COLUMNS, tuple(rows)), selected, height="26vh", more="better ones")


def rank_faces(verdicts: Sequence[FaceVerdict]) -> list[FaceVerdict]:
    """Worst first: by verdict, then by the share that is held."""
    return sorted(verdicts, key=lambda each: (VERDICTS.index(each.verdict), each.held_share))


def verdicts_html(verdicts: Sequence[FaceVerdict], selected: str) -> str:
    """Verdicts as a table, one row for each face and template."""
    rows = [
        (each.face, Text(each.verdict, tone=each.verdict), f"{each.held_share:.1%}", f"{each.least_s:.2f} s")
        for each in verdicts
    ]
    return listing_html(Table(_VERDICTS, tuple(rows)), selected, height="30vh", more="better ones")


def verdict_html(verdicts: Sequence[FaceVerdict], face: str) -> str:
    """Cards of the verdicts on one face, one for each template; what to do where there is none."""
    cards = (card_html(cleaned_face_card(each, source_words(each.made_by))) for each in verdicts if each.face == face)
    return "".join(cards) or quiet_html("Choose a face, or click one in the picture.")
