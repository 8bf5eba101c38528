"""Lines of a table cut into cells by marks, by blanks below titles, or as those of tables without titles."""

import csv
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

Lines: TypeAlias = list[tuple[int, list[str]]]
"""Number and cells of each line; comments have none."""

_MARKS = ",;\t!|"
_MOST_WORDS = 80
"""Words of a line that are laid below titles; more are no row of a table."""
_EMPTY = 200.0
"""Cost of a cell without a word that has to have one: more than words out of place, less than a wrong one."""
_NUMBER = re.compile(r"[-+]?\d[\d.,]*(?:mm|mils?|in|\"|°)?", re.IGNORECASE)
_DESIGNATOR = re.compile(r"[A-Za-z]{1,6}\d+[A-Za-z]?")
_FORMULA = re.compile(r'^\s*="([^"]*)"\s*$')
"""Spreadsheets write texts that they must not read as numbers so."""
PADS = re.compile(r"\s*[!*]PADS-\w+-V?[\d.]+-(MILS|METRIC|INCHES|BASIC)", re.IGNORECASE)
"""The first line of a PADS ASCII file, with its unit."""
_PADS_TYPE = re.compile(r"^(\S+)[ \t]+(\S+)[ \t]+[A-Z]+(?:[ \t]+\d+){2,}", re.MULTILINE)
_PADS_PLACE = r"\s+([-+]?\d{1,12}(?:\.\d{0,12})?)"
_PADS_PART = re.compile(rf"^(\S+)[ \t]+(\S+){_PADS_PLACE * 3}\s+[A-Z]\s+([MNY])\s+-?\d", re.MULTILINE)
"""Designator, type and decal, x, y, turn, whether it is glued, and whether it is mirrored."""
_BASIC_A_MIL = 38100.0
"""Units of the database of PADS in one mil."""
_TITLES = ("designator", "x", "y", "rotation", "value", "package")
"""Of tables without titles, as Eagle's mountsmd writes them."""


@dataclass(frozen=True, slots=True)
class _Word:
    text: str
    start: int
    end: int


def marks_in(text: str) -> list[str]:
    """Marks that may separate cells, the most frequent of the beginning first."""
    return sorted(_MARKS, key=lambda each: -text[:20_000].count(each))


def marked(text: str, mark: str) -> Lines:
    """Cut at a mark."""
    reader = csv.reader(text.splitlines(keepends=True), delimiter=mark, skipinitialspace=True)
    cut: Lines = []
    try:
        for cells in reader:
            plain = [_FORMULA.sub(r"\1", cell) for cell in cells] if '="' in "".join(cells) else cells
            cut.append((reader.line_num, [] if cells and cells[0].startswith("##") else plain))
    except csv.Error:  # a field of more than 131,072 characters: no table of parts
        pass
    return cut


def blank(
    text: str, is_title: Callable[[str], bool], is_number: Callable[[str], bool], is_name: Callable[[str], bool]
) -> Lines | None:
    """Cut at blanks, below titles and with cells that may hold blanks or be empty.

    Args:
        text: Of the file.
        is_title: Whether words are the title of a known column.
        is_number: Whether the cells below a title are numbers.
        is_name: Whether they are designators, one a line where places are stated.

    Returns:
        ``None`` where no line has titles.
    """
    lines = text.splitlines()
    for number, line in enumerate(lines, start=1):
        titles = _join_titles(_words(line.replace("#", " ", 1) if line.startswith("#") else line), is_title)
        if sum(is_title(title.text) for title in titles) < 2 or len(titles) > _MOST_WORDS:
            continue
        numeric = [is_number(title.text) for title in titles]
        single = [
            number or (any(numeric) and is_name(title.text)) for title, number in zip(titles, numeric, strict=True)
        ]
        rest = (
            (place, [] if row.lstrip().startswith("#") else _below(_words(row), titles, numeric, single))
            for place, row in enumerate(lines[number:], start=number + 1)
        )
        return [(number, [title.text for title in titles]), *rest]
    return None


def pads_parts(text: str) -> Lines | None:
    """Cut the section of parts of a PADS ASCII file, whose parts may be broken over lines; ``None`` without one."""
    if (head := PADS.match(text)) is None:
        return None
    types = _PADS_TYPE.finditer(text[slice(*_section(text, "PARTTYPE"))])
    decals = {hit[1]: hit[2].partition(":")[0] for hit in types}
    basic = 1.0 / _BASIC_A_MIL if head[1].upper() == "BASIC" else 1.0
    cut: Lines = [(0, ["designator", "part", "package", "x", "y", "rotation", "mirror"])]
    begin, end = _section(text, "PART")
    line, seen = 1, 0
    for hit in _PADS_PART.finditer(text, begin, end):
        line, seen = line + text.count("\n", seen, hit.start()), hit.start()
        kind, _, decal = hit[2].partition("@")
        places = [f"{float(word) * basic:.4f}" for word in hit.group(3, 4)]
        side = "no" if hit[6].upper() == "N" else "yes"
        cut.append((line, [hit[1], kind, decal or decals.get(kind, kind), *places, hit[5], side]))
    return cut


def _section(text: str, name: str) -> tuple[int, int]:
    """Where a section of a PADS ASCII file begins and ends; remarks are in it."""
    start = re.search(rf"^\*{name}\*", text, re.MULTILINE)
    if start is None:
        return 0, 0
    end = re.compile(r"^\*(?!REMARK)\w+\*", re.MULTILINE).search(text, start.end())
    return start.end(), end.start() if end is not None else len(text)


def untitled(text: str) -> Lines | None:
    """Cut lines that no titles are above: designator, x, y, turn, value, package, as most of them must be.

    Marks ``!`` may stand between them, and the side before the package: Allegro's placement file. Or commas.
    """
    lines = [line.replace("!", " ").split() for line in text.splitlines()]
    if "!" not in text and (separated := [cells for _, cells in marked(text, ",")]) and any(map(_is_placed, separated)):
        lines = [[cell.strip() for cell in cells] for cells in separated]
    rows = [(place, words) for place, words in enumerate(lines, start=1) if _is_placed(words)]
    stated = [words for words in lines if words and words[0][:1] not in "#$*;=-"]
    if not rows or 2 * len(rows) <= len(stated):
        return None
    is_sided = "!" in text
    titles = (*_TITLES[:4], "mirror", "package") if is_sided else _TITLES
    cut: Lines = [(0, list(titles))]
    for place, words in rows:
        last = words[4:]
        if is_sided:
            mirror = last[0] if len(last) > 1 else "no"
            cut.append((place, [*words[:4], mirror, last[-1] if last else ""]))
        else:
            cut.append((place, [*words[:4], " ".join(last[:-1]), last[-1] if last else ""]))
    return cut


def is_designator(text: str) -> bool:
    """Whether a text has the form of a reference designator."""
    return _DESIGNATOR.fullmatch(text) is not None


def _is_placed(words: Sequence[str]) -> bool:
    """Whether words begin with a designator and three numbers."""
    return len(words) >= 4 and bool(_DESIGNATOR.fullmatch(words[0])) and all(map(_NUMBER.fullmatch, words[1:4]))


def _words(line: str) -> list[_Word]:
    return [_Word(hit[0], hit.start(), hit.end()) for hit in re.finditer(r"\S+", line.expandtabs())]


def _join_titles(words: Sequence[_Word], is_title: Callable[[str], bool]) -> list[_Word]:
    """Join words one blank apart that name a column together, such as ``Mid X``."""
    titles: list[_Word] = []
    at = 0
    while at < len(words):
        for count in (3, 2, 1):
            group = words[at : at + count]
            text = " ".join(word.text for word in group)
            near = all(b.start - a.end == 1 for a, b in pairwise(group))
            if count == 1 or (len(group) == count and near and is_title(text)):
                titles.append(_Word(text, group[0].start, group[-1].end))
                at += len(group)
                break
    return titles


def _below(
    words: Sequence[_Word], titles: Sequence[_Word], numeric: Sequence[bool], single: Sequence[bool]
) -> list[str]:
    """Lay the words of a line below the titles so that they are least out of place, in the order of both.

    A column of numbers takes one number, one of designators one word, and neither is left empty; a wide gap inside a
    cell, or one blank between two cells, costs.
    """
    if not words or len(words) > _MOST_WORDS:
        return []
    if len(words) == len(titles):
        return [word.text for word in words]

    def cost(word: _Word, column: int) -> float:
        title = titles[column]
        apart = max(title.start - word.end, word.start - title.end, 0)
        return apart + 1000.0 * (numeric[column] and _NUMBER.fullmatch(word.text) is None)

    best: list[list[tuple[float, int]]] = []
    """By word and column: the cost so far, and the column of the word before."""
    for number, word in enumerate(words):
        row: list[tuple[float, int]] = []
        gap = word.start - words[number - 1].end if number else 0
        lowest = (0.0 if number == 0 else float("inf"), -1)
        for column in range(len(titles)):
            chosen = lowest if number == 0 else (lowest[0] + 3.0 * (gap == 1), lowest[1])
            if number:
                stay = best[-1][column][0] + 5.0 * (gap > 1) + 1000.0 * single[column]
                chosen = min(chosen, (stay, column))
            lowest = lowest[0] + _EMPTY * single[column], lowest[1]
            if number:
                lowest = min(lowest, (best[-1][column][0], column))
            row.append((chosen[0] + cost(word, column), chosen[1]))
        best.append(row)
    cells = [""] * len(titles)
    column = min(range(len(titles)), key=lambda each: best[-1][each][0] + _EMPTY * sum(single[each + 1 :]))
    for number in range(len(words) - 1, -1, -1):
        cells[column] = f"{words[number].text} {cells[column]}".strip()
        column = best[number][column][1]
    return cells
