"""What the page carries of others is named in NOTICE."""

import re
from pathlib import Path

import viser

CLIENT = Path(viser.__file__).parent / "client" / "src"
NOTICE = " ".join((Path(__file__).parents[1] / "NOTICE").read_text("utf-8").split())


def test_the_holders_of_rights_in_the_source_of_the_page_are_named() -> None:
    files = [*CLIENT.rglob("*.ts"), *CLIENT.rglob("*.tsx"), *CLIENT.rglob("LICENSE*")]
    holders = {
        holder.strip(" .")
        for file in files
        for holder in re.findall(r"Copyright \(c\) \d{4}(.*)", file.read_text("utf-8", "replace"))
    }
    assert holders
    assert {holder for holder in holders if holder not in NOTICE} == set()


def test_images_that_the_page_carries_are_named() -> None:
    sources = "".join(file.read_text("utf-8") for file in CLIENT.rglob("*.tsx"))
    images = set(re.findall(r"_assets/[^\"']*?([\w.-]+\.(?:jpg|png|hdr))", sources))
    assert images
    assert {image for image in images if image not in NOTICE} == set()
