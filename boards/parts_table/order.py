"""What comes with a board: the folder or archive of an order, or a file, with tables, netlists and a columns file."""

import os
import re
from collections import Counter
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from boards.board import SourceFile
from boards.errors import BoardError, read_bytes
from boards.formats.archive import is_archive, read_members
from boards.formats.extracts.allegro import has_edge
from boards.formats.gerber.gerber import board_sets, is_gerber, is_layer_name
from boards.formats.kicad.imported import import_board, is_imported
from boards.formats.names import may_be_text, some
from boards.formats.odb.odb import roots_of
from boards.formats.table import ARCHIVES, FORMATS, HEAD, Format, find_format, marked_formats
from boards.parts_table.columns import COLUMNS_FILE, Stated, find_columns, parse_columns
from boards.parts_table.netlist import SUFFIXES as NETLIST_SUFFIXES
from boards.parts_table.netlist import Netlist, read_netlist
from boards.parts_table.read import (
    NoTableError,
    PartsTable,
    Tables,
    is_table_name,
    read_table,
    tables_of,
    unread_titles,
)
from boards.parts_table.tables import Statements
from boards.parts_table.words import plain_title
from boards.parts_table.workbook import WORKBOOKS, is_workbook, read_sheets
from specs.confinement import admit
from specs.errors import printable
from specs.finding import Finding
from specs.finding_rules import ORDER_BOARDS, PARTS_COLUMNS, PARTS_FOUND, PARTS_TITLES
from specs.input_file import InputFile
from specs.temporary import temporary_folder, write_temporary

_IMPORTED = "imported by KiCad"
_STATING = "ODB++ IPC-2581 KiCad Eagle GenCAD Allegro IDF board-tri Gerber STEP glTF mesh"
_KINDS = (*_STATING.split(), _IMPORTED)
"""Formats of boards, those that state most first: of several in one order the first is the board."""
_DRAWN = ("STEP", "glTF", "mesh")
_LONGEST_NAME = 255
"""Bytes of a file's name."""
_MARKS = {
    ".xml": rb"<IPC-2581",
    ".cvg": rb"<IPC-2581",
    ".brd": rb"<eagle|\A\s*\.HEADER",
}
"""Other programs write files of these suffixes, too."""
_MARKED = (*_MARKS, *(suffix for form in FORMATS if form.mark for suffix in form.suffixes))
_SHEETS = (".xls", ".ods")
"""Workbooks that are not read."""
_MOST_ARCHIVES = 20
_DEEPEST = 3


@dataclass(frozen=True, slots=True, eq=False)
class _Holder:
    """A folder, an archive, or an archive in one of them."""

    path: Path
    prefix: str
    """Of its names in the order."""
    names: tuple[str, ...]
    contents: Mapping[str, bytes]
    """Of what may be a table, a netlist or a columns file, and of files whose content has to be seen."""
    roots: tuple[str, ...]
    """Of ODB++ jobs."""

    def is_loose(self, name: str) -> bool:
        """Whether a file is none of an ODB++ job."""
        return not any(name.startswith(root) if root else "/" in name for root in self.roots)


@dataclass(frozen=True, slots=True)
class _Candidate:
    """One reading of what the board is."""

    label: str
    """By which the columns file names it."""
    form: str
    holder: int
    members: tuple[str, ...]
    """Its files, the one to open first; none where it is all that the holder has."""
    folder: str = ""
    """Below which they are opened together."""

    def rank(self) -> tuple[int, bool, int]:
        """Order in which it is taken: by format, what is not packed in the order first, by depth."""
        return _KINDS.index(self.form), self.holder > 0, self.label.count("/")


@dataclass(frozen=True, slots=True, eq=False)
class Rival:
    """A file that is the board in another reading, or a model of it."""

    label: str
    file: Path
    form: Format


@dataclass(frozen=True, slots=True, eq=False)
class Order:
    """A board's file and what comes with it."""

    board: Path
    form: Format
    label: str
    given: Statements
    stated: Stated
    findings: tuple[Finding, ...]
    rivals: tuple[Rival, ...] = ()
    """3-D models and meshes, those that state most first."""

    def sources(self, components: int) -> tuple[SourceFile, ...]:
        """Every file with what it states; none where the board is alone."""
        given = self.given
        board = SourceFile(self.label, f"board, {self.form.name}", f"{components} components")
        tables = (SourceFile(each.file.name, "parts table", _words(each, given)) for each in given.tables)
        lists = (SourceFile(each.file.name, "netlist", each.describe()) for each in given.netlists)
        file = self.stated.file
        stated = [] if file is None else [SourceFile(file.name, "columns file", _stated_words(self.stated))]
        found = (board, *tables, *lists, *stated, *given.others)
        return found if len(found) > 1 else ()


def _words(table: PartsTable, given: Statements) -> str:
    columns = ", ".join(f"{column}: {title}" for column, title in table.titles.items())
    unit = table.unit or given.units.get(table.file, "")
    places = f"; places in {unit}" if unit and "x" in table.titles else ""
    return f"{len(table.rows)} rows; {columns}{places}"


@contextmanager
def open_order(path: Path, parts: Tables = None) -> Generator[Order]:
    """Open a board's file with what comes with it; of a folder or an archive the board is found by content.

    Of an archive the board's file is unpacked into a temporary folder for the time of the block; errors of its reader
    name the archive and the file in it.

    Args:
        path: A file, a folder or an archive.
        parts: Tables and netlists; left out, those in the folder or the archive.

    Raises:
        BoardError: There is no board, or a table, a netlist or the columns file cannot be read.
    """
    shown: list[tuple[Path, Path]] = []
    with ExitStack() as stack:
        try:
            yield _Opening(path, tables_of(parts), stack, shown).order()
        except BoardError as error:
            file = Path(error.file or "")
            real, name = next((each for each in reversed(shown) if file.is_relative_to(each[0])), (None, path))
            reason = error.__context__
            is_systems = isinstance(reason, OSError) and reason.errno and not isinstance(reason, FileNotFoundError)
            if real is None or is_systems:  # what is unpacked cannot be read: not the archive's doing
                raise
            moved = BoardError(str(error).replace(printable(str(real)), printable(str(name)), 1))
            moved.file, moved.line = name / file.relative_to(real), error.line
            raise moved from None


@dataclass(frozen=True, slots=True, eq=False)
class _Opening:
    """An order while it is opened."""

    path: Path
    parts: tuple[Path, ...]
    stack: ExitStack
    shown: list[tuple[Path, Path]]
    """What was unpacked, with the paths that messages have for it."""

    def order(self) -> Order:
        """Find the board, and read what comes with it."""
        stated = find_columns(self.path)
        if not is_archive(self.path):
            contents = self._given()
            tables, netlists, _ = _read(contents, stated, is_given=True)
            given = Statements(tables, netlists, stated.model.heights_mm)
            board = self._imported(self.path)
            return Order(board, find_format(board, "read"), self.path.name, given, stated, _noted(stated, tables))
        holders = list(self._holders(self.path, ""))
        if not any(each.names for each in holders):
            raise BoardError(
                "holds no files: name the folder or the archive that holds the board's files.", file=self.path
            )
        if stated.file is None:
            stated = self._columns_inside(holders)
        chosen, candidates, findings = self._choose(holders, stated)
        found: dict[Path, bytes] = {}
        seen: set[tuple[str, bytes]] = set()
        for holder in holders:
            for name, content in holder.contents.items():
                if is_workbook(content) and (_base(name), content) not in seen:
                    seen.add((_base(name), content))
                    found |= read_sheets(content, self.path / f"{holder.prefix}{name}")
                    continue
                is_board = holder is holders[chosen.holder] and name in chosen.members
                is_text = _is_text(name) and b"\0\0" not in content[:HEAD] and not is_gerber(content)
                if holder.is_loose(name) and is_text and not is_board and (_base(name), content) not in seen:
                    seen.add((_base(name), content))
                    found[self.path / f"{holder.prefix}{name}"] = content
        found = _distinct(found)
        contents = self._given() or self._stated_tables(found, stated)
        tables, netlists, rest = _read(contents, stated, is_given=bool(self.parts))
        sheets = [name for each in holders for name in each.names if name.lower().endswith(_SHEETS) or
                  (name.lower().endswith(WORKBOOKS) and not is_workbook(each.contents.get(name, b"")))]  # fmt: skip
        if (tables or netlists) and not self.parts:
            counts = [f"{each.file.name} ({len(each.rows)} rows)" for each in tables]
            names = ", ".join([*counts, *(f"{each.file.name} ({each.describe()})" for each in netlists)])
            findings.append(Finding(PARTS_FOUND, f"Found beside the board, and joined to it: {names}."))
        board = self._imported(self._unpack(holders[chosen.holder], chosen))
        drawn = [each for each in candidates if each.form in _DRAWN and each is not chosen]
        others = [
            SourceFile(each.label, "not read", f"{each.form}; {chosen.label} is the board")
            for each in candidates
            if each is not chosen and each not in drawn
        ]
        return Order(
            board,
            _format_of(chosen),
            chosen.label,
            Statements(tables, netlists, stated.model.heights_mm, others=[*others, *_unread([*rest], sheets)]),
            stated,
            (*findings, *_noted(stated, tables), *_unknown(rest, tables, stated)),
            tuple(Rival(each.label, self._unpack(holders[each.holder], each), _format_of(each)) for each in drawn),
        )

    def _given(self) -> dict[Path, bytes]:
        """Tables and netlists that are given; of a workbook its sheets that are tables, or all where none is."""
        found: dict[Path, bytes] = {}
        for file in self.parts:
            content = read_bytes(file, "parts table")
            sheets = read_sheets(content, file) if is_workbook(content) else {file: content}
            found |= {
                each: text for each, text in sheets.items() if len(sheets) == 1 or _has_table(each, text)
            } or sheets
        return _distinct(found)

    def _holders(self, path: Path, prefix: str, depth: int = 1) -> Iterator[_Holder]:
        """Look into a folder or an archive, and into the archives in it."""

        def is_needed(name: str) -> bool:
            is_packed = name.lower().endswith(ARCHIVES) and not path.is_dir()
            is_marked = name.lower().endswith(_MARKED) or _base(name) == COLUMNS_FILE
            return _is_text(name) or is_packed or is_marked or name.lower().endswith(WORKBOOKS)

        names, contents = read_members(path, is_needed)
        holder = _Holder(path, prefix, names, contents, tuple(roots_of(names)))
        yield holder
        packed = [name for name in names if name.lower().endswith(ARCHIVES)]
        if len(packed) > _MOST_ARCHIVES:
            if any(_candidates(0, holder)):  # these are backups of it
                return
            raise BoardError(f"holds {len(packed)} archives: name the one of the board.", file=path)
        for name in packed if depth < _DEEPEST and not holder.roots else ():
            file = path / name
            if not path.is_dir():
                file = self._write({name: contents[name]}, path, prefix)[name]
            yield from self._holders(file, f"{prefix}{name}/", depth + 1)

    def _write(self, contents: Mapping[str, bytes], holder: Path, prefix: str) -> dict[str, Path]:
        """Unpack files for the time of the block.

        Raises:
            BoardError: One has a name that no file can have.
        """
        for name in contents:
            if any(len(os.fsencode(part)) > _LONGEST_NAME for part in name.split("/")):
                text = (
                    f"holds the name {printable(name)[:80]!r} …, which is too long for a file. Give it a shorter one."
                )
                raise BoardError(text, file=holder)
        root = self.stack.enter_context(temporary_folder())
        self.shown.append((root, self.path / prefix))
        files = {name: write_temporary(root, name, content) for name, content in contents.items()}
        self.stack.enter_context(admit(root, *files.values()))
        return files

    def _imported(self, board: Path) -> Path:
        """The board, or what KiCad makes of one that it imports."""
        if not is_imported(board.name, InputFile(board, BoardError, "board file").head(HEAD)):
            return board
        root = self.stack.enter_context(temporary_folder())
        made = import_board(board, root)
        self.shown.append((made, board))
        self.stack.enter_context(admit(root, made))
        return made

    def _columns_inside(self, holders: Sequence[_Holder]) -> Stated:
        inside = [(name, each) for each in holders for name in each.contents if _base(name) == COLUMNS_FILE]
        for name, holder in sorted(inside, key=lambda each: len(each[0]))[:1]:
            file = self.path / f"{holder.prefix}{name}"
            return Stated(file, parse_columns(holder.contents[name].decode("utf-8", "replace"), file))
        return Stated()

    def _stated_tables(self, found: Mapping[Path, bytes], stated: Stated) -> Mapping[Path, bytes]:
        """Keep the tables that the columns file lists, where it lists some."""
        if stated.model.tables is None:
            return found
        paths = {file.relative_to(self.path).as_posix(): file for file in found}
        kept: dict[Path, bytes] = {}
        for name in stated.model.tables:
            files = [file for path, file in paths.items() if name in (path, file.name) or
                     path.startswith(f"{name} [") or file.name.startswith(f"{name} [")]  # fmt: skip
            if not files:
                message = f"{name} is not in the order. Its texts are {some([*paths]) or 'none'}."
                raise BoardError(message, path="tables", file=stated.file)
            kept |= {file: found[file] for file in files}
        return kept

    def _choose(self, holders: Sequence[_Holder], stated: Stated) -> tuple[_Candidate, list[_Candidate], list[Finding]]:
        """Choose the board: the one that is stated, else the one whose format states most."""
        found = [each for number, holder in enumerate(holders) for each in _candidates(number, holder)]
        if not found:
            suffixes = ", ".join(sorted({PurePosixPath(name).suffix for each in holders for name in each.names} - {""}))
            raise BoardError(
                "holds no ODB++ job, no IPC-2581 file, no Gerber layer that is the board's profile, and no other file "
                f"of a board{f', only {suffixes}' if suffixes else ''}. Export the board into it as well.",
                file=self.path,
            )
        found.sort(key=lambda each: (each.rank(), each.label))
        if stated.model.board is not None:
            named = [each for each in found if each.label == stated.model.board]
            if not named:
                message = (
                    f"{stated.model.board} is not in the order. Its boards are {some([each.label for each in found])}."
                )
                raise BoardError(message, path="board", file=stated.file)
            chosen, alike = named[0], []
        else:
            chosen = found[0]
            alike = [each.label for each in found if each.rank() == chosen.rank()]
        if len(alike) < 2:
            return chosen, found, []
        text = (
            f"The order holds {len(alike)} boards: {some(alike)}. {chosen.label} is taken; name the one that is meant "
            f"in {COLUMNS_FILE} beside the order, as `board: {alike[1]}`."
        )
        return chosen, found, [Finding(ORDER_BOARDS, text)]

    def _unpack(self, holder: _Holder, chosen: _Candidate) -> Path:
        """Path that the reader opens."""
        if not chosen.members:
            return holder.path
        if holder.path.is_dir() and len(chosen.members) == 1:
            return holder.path / chosen.members[0]
        first = PurePosixPath(chosen.members[0])
        beside = {
            name
            for name in map(PurePosixPath, holder.names)
            if len(chosen.members) == 1
            and name.parent == first.parent
            and (name.stem.lower() == first.stem.lower() or name.suffix.lower() == ".bin")
        }
        needed = {*chosen.members, *map(str, beside)}
        files = self._write(read_members(holder.path, lambda name: name in needed)[1], holder.path, holder.prefix)
        if len(chosen.members) == 1:
            return files[chosen.members[0]]
        some_file = files[chosen.members[0]]
        depth = len(first.parts) - len(PurePosixPath(chosen.folder).parts)
        return some_file.parents[depth - 1]


def _format_of(candidate: _Candidate) -> Format:
    name = "KiCad" if candidate.form == _IMPORTED else candidate.form
    return next(form for form in FORMATS if form.name == name)


def _base(name: str) -> str:
    return name.rpartition("/")[2].lower()


def _is_text(name: str) -> bool:
    is_known = is_table_name(name) or name.lower().endswith(NETLIST_SUFFIXES)
    return is_known or (may_be_text(name) and not is_layer_name(name))


def _candidates(number: int, holder: _Holder) -> Iterator[_Candidate]:
    """Yield what may be the board in a folder or an archive."""
    here = holder.prefix.rstrip("/") or holder.path.name
    for root in holder.roots:
        members = tuple(name for name in holder.names if name.startswith(root)) if len(holder.roots) > 1 else ()
        yield _Candidate(f"{holder.prefix}{root}".rstrip("/") or here, "ODB++", number, members, root)
    loose = [name for name in holder.names if holder.is_loose(name)]
    stems = {PurePosixPath(name).with_suffix("").as_posix().lower() for name in loose if name.lower().endswith(".emn")}
    for name in loose:
        form = _form_of(name, holder.contents.get(name, b""))
        is_library = name.lower().endswith(".emp") and PurePosixPath(name).with_suffix("").as_posix().lower() in stems
        if form is not None and not is_library:
            yield _Candidate(f"{holder.prefix}{name}", form, number, (name,))
    sets = board_sets([name for name in loose if is_layer_name(name) or is_gerber(holder.contents.get(name, b""))])
    for label, members in sets.items():
        folder = label if len(sets) > 1 and all(name.startswith(f"{label}/") for name in members) else ""
        name = f"{holder.prefix}{label}" if len(sets) > 1 else here
        yield _Candidate(name, "Gerber", number, members if len(sets) > 1 else (), folder)


def _form_of(name: str, content: bytes) -> str | None:
    """Name of the format of a file that holds a board by itself."""
    suffix = PurePosixPath(name.lower()).suffix
    mark = _MARKS.get(suffix)
    if mark is not None and not re.search(mark, content[:HEAD], re.IGNORECASE):
        return None
    if is_imported(name, content[:HEAD]):
        return _IMPORTED
    forms = [each for each in FORMATS if each.read and name.lower().endswith(each.suffixes)]
    marked = [each for each in marked_formats(content[:HEAD]) if each.read]
    forms = [each for each in forms if not each.mark or each in marked] or marked
    own = [each.name for each in forms if not name.lower().endswith(ARCHIVES) and each.name != "Gerber"]
    if own[:1] == ["Allegro"] and not has_edge(content):
        return None
    if suffix == ".brd":
        return "Eagle" if b"<eagle" in content[:HEAD].lower() else "IDF"
    return own[0] if own else None


def _read(
    contents: Mapping[Path, bytes], stated: Stated, *, is_given: bool
) -> tuple[tuple[PartsTable, ...], tuple[Netlist, ...], dict[str, tuple[str, ...]]]:
    """Read tables and netlists; of what is neither, which is an error where it was given, the titles by its name."""
    tables: list[PartsTable] = []
    netlists: list[Netlist] = []
    rest: dict[str, tuple[str, ...]] = {}
    for file, content in contents.items() if is_given else sorted(contents.items()):
        try:
            netlist = read_netlist(content, file)
            if netlist is not None:
                netlists.append(netlist)
            else:
                tables.append(read_table(file, content, stated))
        except NoTableError:
            if is_given:
                raise
            rest[file.name] = unread_titles(file, content)
    if is_given and tables and not netlists and not any(each.rows for each in tables):
        raise BoardError("the table has no row with a reference designator.", file=tables[0].file)
    return tuple(tables), tuple(netlists), rest


def _distinct(found: Mapping[Path, bytes]) -> dict[Path, bytes]:
    """Files of one name in several folders are called after their folders as well: ``cpl.csv [top]``."""
    counts = Counter(file.name for file in found)
    return {
        file if counts[file.name] == 1 else file.with_name(f"{file.name} [{file.parent.name}]"): content
        for file, content in found.items()
    }


def _has_table(file: Path, content: bytes) -> bool:
    try:
        read_table(file, content)
    except NoTableError:
        return False
    except BoardError:  # of a table, which is noted where it is read
        pass
    return True


def _unknown(rest: Mapping[str, tuple[str, ...]], tables: Sequence[PartsTable], stated: Stated) -> Iterator[Finding]:
    """Yield a finding for each text that seems to be a table whose titles are not known."""
    is_placed = any("x" in each.titles for each in tables)
    for name, titles in sorted(rest.items()):
        if titles and stated.model.tables is None:
            shown = "; ".join(printable(title)[:40] for title in titles[:12])
            text = (
                f"{name} seems to be a parts table, but its titles are not known: {shown}. State them in "
                f"{COLUMNS_FILE} beside the order, as `columns: {{ref: TITLE, x: TITLE, y: TITLE, side: TITLE}}`, or "
                "the tables that are meant, as `tables: []`."
            )
            yield Finding(PARTS_TITLES, text, override="warning" if is_placed else None)


def _unread(names: Sequence[str], sheets: Sequence[str]) -> list[SourceFile]:
    found = [SourceFile(name, "not read", "save it as CSV to have it joined") for name in sheets]
    rest = [SourceFile("other texts", "not read", f"no parts table: {some(names)}")] if names else []
    return [*found, *rest]


def _stated_words(stated: Stated) -> str:
    model = stated.model
    columns = [f"{column}: {' or '.join(titles)}" for column, titles in stated.titles.items()]
    unit = [f"unit {model.unit}"] if model.unit else []
    board = [f"board {model.board}"] if model.board else []
    board += [f"panel {model.panel}"] if model.panel else []
    listed = [f"tables {', '.join(model.tables)}"] if model.tables is not None else []
    heights = [f"heights of {some(list(model.heights_mm))}"] if model.heights_mm else []
    return "; ".join([*columns, *unit, *board, *listed, *heights]) or "nothing"


def _noted(stated: Stated, tables: Sequence[PartsTable]) -> tuple[Finding, ...]:
    """What a columns file states, and which of its titles no table has."""
    if stated.file is None:
        return ()
    notes = [Finding(PARTS_COLUMNS, f"{stated.file.name} is used: {_stated_words(stated)}.")]
    for column, titles in stated.titles.items():
        own = {plain_title(title) for title in titles}
        if tables and not any(plain_title(each.titles.get(column, "")) in own for each in tables):
            text = f"{stated.file.name}: columns.{column}: no table has a column {' or '.join(map(repr, titles))}."
            notes.append(Finding(PARTS_COLUMNS, text, override="warning"))
    return tuple(notes)
