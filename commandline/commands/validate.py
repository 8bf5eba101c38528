"""``washboard validate``: the cleaning model against published readings and laws."""

import os
from functools import partial
from typing import Annotated

import typer

from commandline.arguments import DataOutput, Picture, input_argument, output_option
from specs.output_file import OutputFile

_NOT_AS_EXPECTED = 1


def validate(
    references: Annotated[
        list[str] | None,
        input_argument("REFERENCE", "References of the library, or folders of your own; left out: the whole library."),
    ] = None,
    data: DataOutput = None,
    picture: Picture = None,
    document: Annotated[
        OutputFile | None, output_option("--document", "PAGE.md", "The same as a page, which shows the picture.")
    ] = None,
) -> None:
    """Compare the cleaning model with what others published: ratios and exponents against what was accepted before.

    Ends with 1 where something fails that is not expected to, or holds that is expected to fail.

    [dim]washboard validate
    washboard validate film-jump --picture film.svg
    washboard validate --document docs/validation.md --picture docs/images/validation.png[/dim]
    """
    from commandline.loading import finish, progress_bar
    from reports.cards.validation import validation_card, validation_document
    from reports.files.write_run import json_bytes
    from reports.pictures.validation_picture import draw_validation
    from washboard.validated import validate as compare

    with progress_bar() as progress:
        validated = compare(*references or (), progress=progress)
    link = ""
    if document is not None and picture is not None:
        link = os.path.relpath(picture.path, document.path.parent).replace(os.sep, "/")
    finish(
        validation_card(validated.comparisons),
        data=(data, lambda _: json_bytes(validated.data())),
        picture=(picture, partial(draw_validation, validated.comparisons)),
        document=(document, lambda _: validation_document(validated.comparisons, link)),
    )
    if not validated.as_expected:
        raise typer.Exit(_NOT_AS_EXPECTED)
