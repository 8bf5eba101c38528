"""The command ``washboard`` with all it has: the command line below, and the browser above it."""

from rulesengine import cli
from webui.command import ui

cli.app.command("ui")(ui)


def main() -> None:
    """Run ``washboard``."""
    cli.main()
