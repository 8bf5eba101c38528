"""The ``.tri`` files that ``board import`` and the commands of ``part`` write."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

from specs.output_file import OutputFile

if TYPE_CHECKING:
    from boards.board import Body


def check_tri_name(output: OutputFile, kind: str) -> None:
    """Refuse another ending, before the long work begins.

    Args:
        output: Where to write.
        kind: What is written, in the plural, such as ``"board files"``.

    Raises:
        BoardError: the name ends in neither ``.tri`` nor ``.tri.gz``.
    """
    from boards.errors import BoardError

    if not output.path.name.endswith((".tri", ".tri.gz")):
        raise BoardError(f"{kind} end in .tri or .tri.gz; name the output so.", file=output.path)


def tri_content(output: OutputFile, bodies: "Iterable[Body]") -> bytes:
    """Bodies as text, compressed where the name ends in ``.gz``; the same bodies give the same bytes."""
    import gzip

    from boards.formats.tri.tri import write_tri

    content = write_tri(bodies).encode("utf-8", errors="replace")
    return gzip.compress(content, mtime=0) if output.path.suffix == ".gz" else content
