"""The numbers-only layout of the 1993 paper: objects, then for each its surfaces, for each of these its patches."""

from pathlib import Path

import numpy as np

from boards.errors import BoardError
from boards.formats.tri.tri_records import Item, Layout
from boards.formats.tri.tri_text import Content
from geometry.arrays import Indices


def read_legacy_layout(content: Content, file: Path) -> Layout:
    """Follow the counts in a stream of numbers. Line breaks are free, but a patch a line is checked line by line.

    Raises:
        BoardError: A count is wrong, or numbers are missing or left over.
    """
    stream = _Stream(content, file)
    items: list[Item] = []
    blocks: list[tuple[Indices, int]] = []
    for number in range(stream.take_count("objects")):
        name = f"object-{number + 1}"
        item = Item(name, stream.line(), {}, stream.take_count(f"surfaces of {name}"))
        for surface in range(item.stated_surfaces):
            what = f"patches of surface {surface + 1} of {name}"
            patches = stream.take_count(what)
            blocks.append(stream.take_patches(patches, what))
            item.surfaces.append((str(surface + 1), patches))
        items.append(item)
    stream.finish()
    if not items:
        raise BoardError("states no objects.", file=file, line=int(content.numbers.lines[0]))
    offsets = np.concatenate([np.empty(0, np.int64), *(begin for begin, _ in blocks)])
    widths = np.repeat([width for _, width in blocks], [len(begin) for begin, _ in blocks]).astype(np.int64)
    return Layout(tuple(items), "mm", offsets, widths, stream.lines_at(offsets), legacy=True)


class _Stream:
    """A place in the numbers of a file."""

    def __init__(self, content: Content, file: Path) -> None:
        self.values = content.numbers.values
        self.counts = content.numbers.counts
        self.lines = content.numbers.lines
        self.begins = np.cumsum(self.counts) - self.counts
        self.file = file
        self.place = 0

    def lines_at(self, offsets: Indices) -> Indices:
        return self.lines[np.searchsorted(self.begins, offsets, side="right") - 1]

    def line(self) -> int:
        return int(self.lines[np.searchsorted(self.begins, self.place, side="right") - 1])

    def take_count(self, what: str) -> int:
        if self.place >= len(self.values):
            raise BoardError(f"ends where the number of {what} is expected.", file=self.file, line=int(self.lines[-1]))
        value = float(self.values[self.place])
        if value != int(value) or not 0 <= value < 1e9:
            raise BoardError(
                f"the number of {what} is expected here, found {value:g}.", file=self.file, line=self.line()
            )
        self.place += 1
        return int(value)

    def take_patches(self, patches: int, what: str) -> tuple[Indices, int]:
        width = 12
        if patches and self.place < len(self.values):
            row = int(np.searchsorted(self.begins, self.place, side="right")) - 1
            count = int(self.counts[row])
            if self.begins[row] == self.place and not (count > 12 or (12 % count == 0 and count < 12)):
                width = 9 if count == 9 else 12
                self._check_rows(row, patches, width, what)
        if self.place + patches * width > len(self.values):
            message = f"ends before all {patches} {what} are read: {width} numbers each."
            raise BoardError(message, file=self.file, line=int(self.lines[-1]))
        begins = self.place + width * np.arange(patches, dtype=np.int64)
        self.place += patches * width
        return begins, width

    def _check_rows(self, row: int, patches: int, width: int, what: str) -> None:
        counts = self.counts[row : row + patches]
        bad = np.flatnonzero(counts != width)
        if bad.size:
            line = int(self.lines[row + bad[0]])
            message = f"{counts[bad[0]]} numbers where patch {bad[0] + 1} of {patches} ({what}) needs {width}."
            raise BoardError(message, file=self.file, line=line)

    def finish(self) -> None:
        if self.place < len(self.values):
            left = len(self.values) - self.place
            message = f"{left} numbers are left over after the last patch. Correct the counts above."
            raise BoardError(message, file=self.file, line=self.line())
