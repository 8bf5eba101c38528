"""Where the files of a robot's program go: one file under a name of its own, or a folder."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from programs.posts.dialect import Dialect
from reports.files.atomic_write import OutputError, output_errors, write_files, write_text_atomically
from reports.files.write_run import check_apart, check_folder


def check_output(output: Path, language: Dialect, read: Sequence[str | Path | None]) -> None:
    """Refuse a place where a program of this language cannot be, before the long work begins.

    A place with a suffix that is not a folder by now is a file, any other a folder.

    Args:
        output: Where the program is to be written.
        language: Its language.
        read: What the command reads.

    Raises:
        OutputError: it cannot be written there, is no file of this language, or the language has several files.
    """
    if not _is_file(output):
        check_folder(output)
        return
    check_apart(read, [output])
    form = language.form
    if form.several:
        reason = f"a program in {language.title} is several files ({', '.join(form.several)})"
        raise OutputError(output, reason, "Name a folder, without a suffix.")
    named = {form.suffix.lower(), *form.also}
    if output.suffix.lower() not in named:
        reason = f"a program in {language.title} is a {form.suffix} file"
        raise OutputError(output, reason, f"Name a {form.suffix} file, or a folder without a suffix.")


def write_program(output: Path, files: Mapping[str, str], language: Dialect) -> list[Path]:
    """Write a program's files whole or not at all; give their paths, the one to start with first.

    Args:
        output: A file, or a folder: as ``check_output`` reads it.
        files: Text by file name, the one to start with first; ASCII.
        language: Their language.

    Raises:
        OutputError: they cannot be written there, or something else is there.
    """
    if _is_file(output):
        if len(files) > 1:
            reason = f"the program is longer than one file of {language.title} holds, and has {len(files)}"
            raise OutputError(output, reason, "Name a folder, without a suffix.")
        write_text_atomically(output, next(iter(files.values())))
        return [output]
    if project := language.folder(files):
        with output_errors(output):
            output.mkdir(exist_ok=True)
        return write_files(output / project, files)
    _check_left_over(output, files, language)
    return write_files(output, files)


def _is_file(output: Path) -> bool:
    return bool(output.suffix) and not output.is_dir()


def _check_left_over(folder: Path, files: Mapping[str, str], language: Dialect) -> None:
    """Refuse a folder in which a list of an earlier, longer program would load files that are not this one's."""
    for name in files:
        stem = name.removesuffix(language.form.suffix)
        for left in (folder / f"{stem}{suffix}" for suffix in language.form.beside):
            if left.name not in files and left.exists():
                reason = f"{left.name} there belongs to a longer program"
                raise OutputError(folder, reason, "Remove it, or name another folder.")
