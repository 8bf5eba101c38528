"""The difference of two recipes as people read it."""

import difflib


def recipe_diff(before: str, after: str, name_before: str, name_after: str) -> str:
    """Write a unified diff; empty where nothing differs."""
    lines = difflib.unified_diff(
        before.splitlines(keepends=True), after.splitlines(keepends=True), name_before, name_after
    )
    return "".join(line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n" for line in lines)
