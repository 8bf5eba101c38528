"""Files that people name on the command line: found by library name or path, read as text."""

import difflib
import os
import stat
from collections.abc import Mapping
from pathlib import Path

from specs.yaml.document import Document

_LARGEST_FILE = 1_000_000


def find_file(source: str | Path, library: Mapping[str, Path], document: Document) -> Path:
    """Find a file: a library name first, then a path.

    Raises:
        JobError: the document's own: a bare name that is neither in the library nor a file.
    """
    if isinstance(source, str) and source in library:
        return library[source]
    path = Path(source)
    if is_bare(str(source)) and not os.path.lexists(path):
        near = difflib.get_close_matches(str(source), library, n=1)
        hint = f" Did you mean {near[0]!r}?" if near else ""
        names = ", ".join(library)
        message = f"no {document.noun} {str(source)!r}.{hint} The library has {names}; or give the path of a file."
        raise document.error(message)
    return path


def is_bare(name: str) -> bool:
    """Tell a name from a path."""
    return bool(name) and "\0" not in name and not Path(name).suffix and name == Path(name).name


def read_text(path: Path, document: Document) -> str:
    """Read a UTF-8 file of a sensible size.

    Raises:
        JobError: the document's own: it cannot be read as text.
    """
    noun = document.noun
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise document.error(f"is not a file; give the path of a {noun} in YAML", file=path)
        if status.st_size > _LARGEST_FILE:
            message = f"{status.st_size:,} bytes are too many; a {noun} has at most {_LARGEST_FILE:,}"
            raise document.error(message, file=path)
        content = path.read_bytes()
    except FileNotFoundError:
        hint = f"no such file; `{document.listed_by}` shows the library"
        raise document.error(hint, file=path) from None
    except (OSError, ValueError) as error:
        raise document.error(f"cannot be read: {getattr(error, 'strerror', None) or error}", file=path) from None
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise document.error("is not UTF-8 text; save it as UTF-8", file=path, line=line) from None
