"""Tables in workbooks of spreadsheets (``.xlsx``), each sheet as a text that is read like any other table."""

import csv
import io
import re
from collections.abc import Callable, Mapping
from pathlib import Path, PurePosixPath

from boards.errors import BoardError
from boards.formats.archive import read_zip
from boards.formats.xml_tree import XmlElement, XmlWords, read_xml
from specs.errors import printable

WORKBOOKS = (".xlsx", ".xlsm")
_BOOK = "xl/workbook.xml"
_LINKS = "xl/_rels/workbook.xml.rels"
_TEXTS = "xl/sharedStrings.xml"
_PART = re.compile(r"xl/(?:worksheets/|_rels/)?[^/]+\.(?:xml|rels)")
_ZIP = b"PK\x03\x04"
_DIRECTORY = 300_000
"""Bytes in which the names of an archive's files stand, at its end."""
_HIDDEN = frozenset({"hidden", "veryHidden"})
_MOST_SHEETS = 100
_MOST_ROWS = 1_048_576
_MOST_COLUMNS = 256
"""Cells farther right are no columns of a table of parts."""
_MOST_BYTES = 100_000_000
"""Of its parts, unpacked, and of the text of a sheet."""
_CHUNK = 1 << 20
_PLACE = re.compile(r"([A-Z]{1,3})(\d{1,7})")
_ESCAPED = re.compile(r"_x([0-9A-Fa-f]{4})_")
_WORDS = XmlWords(
    "workbook",
    "Save its tables as CSV.",
    frozenset({"f", "rPh", "phoneticPr", "cols", "mergeCells", "conditionalFormatting", "dataValidations", "extLst"}),
    deepest=40,
    most_elements=100_000_000,
    most_kept=2_000_000,
    kept_texts=frozenset({"t", "v"}),
)


def is_workbook(content: bytes) -> bool:
    """Whether a file is a workbook, whatever it is called: an archive with the parts of one."""
    return content.startswith(_ZIP) and _BOOK.encode() in content[-_DIRECTORY:]


def read_sheets(content: bytes, file: Path) -> dict[Path, bytes]:
    """Give the visible sheets of a workbook as texts, in UTF-8 with tabs between cells; lines are rows of the sheet.

    Args:
        content: Of the workbook.
        file: Its path. A sheet is called ``NAME.xlsx [SHEET]``, and as the workbook where it is the only one.

    Raises:
        BoardError: It is damaged, needs a password, declares entities or holds more than a table of parts does.
    """
    parts = read_zip(content, file, lambda name: _PART.fullmatch(name) is not None)
    if sum(map(len, parts.values())) > _MOST_BYTES:
        raise BoardError(
            "a workbook of more than 100 MB, unpacked, is no table of parts. Save as CSV what is.", file=file
        )

    def parse(name: str, taken: Mapping[str, Callable[[XmlElement], None]] | None = None) -> XmlElement | None:
        text = parts.get(name)
        if text is None:
            return None
        chunks = (text[begin : begin + _CHUNK] for begin in range(0, len(text), _CHUNK))
        return read_xml(chunks, file, _WORDS, XmlElement, taken)

    book, links = parse(_BOOK), parse(_LINKS)
    if book is None or links is None:
        raise BoardError("the workbook is damaged: it lists no sheets. Save its tables as CSV.", file=file)
    targets = {each.word("Id"): each.word("Target") for each in links.all("Relationship")}
    sheets = [each for each in book.inside("sheets") if each.word("state") not in _HIDDEN][:_MOST_SHEETS]
    texts: list[str] = []
    parse(_TEXTS, {"si": lambda each: texts.append(_text(each))})
    found: dict[Path, bytes] = {}
    for sheet in sheets:
        target = next((targets.get(value, "") for key, value in sheet.attributes.items() if key.endswith(":id")), "")
        rows = _Rows(file, texts)
        if parse(str(PurePosixPath("xl", target)).lstrip("/"), {"row": rows.take}) is not None and rows.number:
            name = re.sub(r"[\[\]/\\\0]", "_", printable(sheet.word("name"))[:80])
            found[file.with_name(f"{file.name} [{name}]")] = rows.text()
    return found if len(found) != 1 else {file: next(iter(found.values()))}


def _text(item: XmlElement) -> str:
    """Text of an item with all its runs."""
    text = "".join(word for each in item.below() if each.tag == "t" for word in each.words)
    return _ESCAPED.sub(lambda hit: chr(int(hit[1], 16)), text)


class _Rows:
    """Rows of a sheet as they are read."""

    def __init__(self, file: Path, texts: list[str]) -> None:
        self._file, self._texts = file, texts
        self._out = io.StringIO()
        self._writer = csv.writer(self._out, delimiter="\t", lineterminator="\n")
        self._size = self.number = 0
        """Characters so far, and the number of the last row."""

    def take(self, row: XmlElement) -> None:
        """Write a row at its number."""
        stated = row.word("r")
        number = int(stated) if stated.isascii() and stated.isdigit() and len(stated) < 8 else self.number + 1
        if number > _MOST_ROWS:
            return
        self._out.write("\n" * (number - self.number - 1))
        self.number = max(number, self.number + 1)
        cells: list[str] = []
        for cell in row.all("c"):
            column = _column(cell.word("r"), len(cells))
            if column < _MOST_COLUMNS:
                cells += [""] * (column + 1 - len(cells))
                cells[column] = " ".join(self._value(cell).split())
        self._size += self._writer.writerow(cells)
        if self._size > _MOST_BYTES:
            raise BoardError("a sheet of more than 100 MB of text is no table of parts.", file=self._file)

    def _value(self, cell: XmlElement) -> str:
        inline = cell.first("is")
        if inline is not None:
            return _text(inline)
        stated = cell.first("v")
        text = "".join(stated.words).strip() if stated is not None else ""
        match cell.word("t"):
            case "s":
                place = int(text) if text.isascii() and text.isdigit() and len(text) < 10 else -1
                return self._texts[place] if 0 <= place < len(self._texts) else ""
            case "b":
                return {"1": "TRUE", "0": "FALSE"}.get(text, "")
            case "e":
                return ""
            case "str" | "inlineStr" | "d":
                return text
            case _:
                try:
                    return f"{float(text):.12g}" if "." in text or "e" in text.lower() else text
                except ValueError:
                    return text

    def text(self) -> bytes:
        return self._out.getvalue().encode("utf-8", "replace")


def _column(place: str, following: int) -> int:
    """Number of a column from 0 by the place of a cell such as ``AB12``; else the one that follows."""
    hit = _PLACE.fullmatch(place)
    if hit is None:
        return following
    number = 0
    for letter in hit[1]:
        number = 26 * number + ord(letter) - 64
    return number - 1
