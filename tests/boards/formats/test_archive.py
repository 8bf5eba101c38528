"""Archives and XML files that promise too much or lead out of themselves: one sentence each, and little memory."""

import errno
import gzip
import io
import os
import tarfile
import tracemalloc
import zipfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest
from command import washboard
from ecad_writers import EcadBoard, EcadPart, gerber_profile, ipc2581, odb, write_folder, write_tgz, write_zip
from hypothesis import given
from hypothesis import strategies as st
from lzw_packer import compress_lzw
from shapely import box

from boards.errors import BoardError
from boards.formats.archive import unpack_lzw
from boards.formats.odb.odb import roots_of
from boards.load import load_board

CARD = EcadBoard(box(0, 0, 30, 20), 1.6, (EcadPart("U1", 9, 9, 4, 3, 1, 0, "top"),))
JOB = odb(CARD)
MOST_MEMORY = 40_000_000


def refused(path: Path) -> str:
    """Sentence with which a board is refused, on one line, with the memory that took bounded."""
    tracemalloc.start()
    try:
        with pytest.raises(BoardError) as caught:
            load_board(path)
        assert tracemalloc.get_traced_memory()[1] < MOST_MEMORY
    finally:
        tracemalloc.stop()
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    assert "Error" not in message
    return message


def tar_of(file: Path, *members: tuple[tarfile.TarInfo, bytes]) -> Path:
    with tarfile.open(file, "w:gz") as archive:
        for member, data in members:
            member.size = len(data)
            archive.addfile(member, io.BytesIO(data))
    return file


def member(name: str, kind: bytes = tarfile.REGTYPE, target: str = "") -> tarfile.TarInfo:
    info = tarfile.TarInfo(name)
    info.type, info.linkname = kind, target
    return info


@pytest.mark.parametrize("name", ["job:1", "ab:1/x", "a/b", "..x/y"])
def test_what_looks_like_a_path_that_leads_out_and_does_not_is_read(name: str, tmp_path: Path) -> None:
    assert "leads out" not in refused(tar_of(tmp_path / "b.tgz", (member(name), b"x")))


@pytest.mark.parametrize("name", ["../matrix/matrix", "/etc/passwd", "job/../../x", "a\\..\\b", "C:/x"])
def test_paths_that_lead_out_are_refused(name: str, tmp_path: Path) -> None:
    tar = tar_of(tmp_path / "b.tgz", (member("matrix/matrix"), JOB["matrix/matrix"].encode()), (member(name), b"x"))
    assert "leads out of it" in refused(tar)
    with zipfile.ZipFile(tmp_path / "b.zip", "w") as archive:
        archive.writestr("matrix/matrix", JOB["matrix/matrix"])
        archive.writestr(name, "x")
    assert "leads out of it" in refused(tmp_path / "b.zip")


@pytest.mark.parametrize("kind", [tarfile.SYMTYPE, tarfile.LNKTYPE, tarfile.CHRTYPE, tarfile.FIFOTYPE])
def test_links_and_devices_in_a_packed_job_are_refused(kind: bytes, tmp_path: Path) -> None:
    tar = tar_of(tmp_path / "b.tgz", (member("job/steps/card/profile", kind, "/etc/passwd"), b""))
    assert "is a link or a device" in refused(tar)


def test_links_in_a_zip_are_refused(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "b.zip", "w") as archive:
        link = zipfile.ZipInfo("matrix/matrix")
        link.external_attr = 0o120777 << 16
        archive.writestr(link, "/etc/passwd")
    assert "is a link or a device" in refused(tmp_path / "b.zip")


def test_a_link_that_leads_out_of_a_folder_is_refused(tmp_path: Path) -> None:
    secret = tmp_path / "secret"
    secret.write_text("UNITS=MM\n")
    job = tmp_path / "job"
    write_folder(JOB, job)
    (job / "steps/card/profile").unlink()
    (job / "steps/card/profile").symlink_to(secret)
    assert "the link 'steps/card/profile', which leads out of it" in refused(job)


@pytest.mark.slow
def test_a_packed_job_that_unpacks_without_end_is_refused(tmp_path: Path) -> None:
    with tarfile.open(tmp_path / "b.tgz", "w:gz") as archive:
        large = member("job/user/zeros")
        large.size = 200_000_000
        archive.addfile(large, zeros(large.size))  # type: ignore[arg-type]
    assert "unpacks to more than 100 times its size" in refused(tmp_path / "b.tgz")


class zeros(io.RawIOBase):  # noqa: N801
    """That many zeros."""

    def __init__(self, size: int) -> None:
        self.left = size

    def read(self, size: int = -1, /) -> bytes:
        size = self.left if size < 0 else min(size, self.left)
        self.left -= size
        return bytes(size)


def test_a_zip_that_unpacks_without_end_is_refused(tmp_path: Path) -> None:
    files = {**JOB, "steps/card/eda/data": "U" * 30_000_000}
    write_zip(files, tmp_path / "b.zip")
    assert "unpacks to more than 100 times its size" in refused(tmp_path / "b.zip")


@pytest.mark.parametrize("method", [zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_a_zip_that_unpacks_to_more_than_it_states_is_refused(method: int, tmp_path: Path) -> None:
    """The libraries unpack bzip2 and LZMA at once, whatever that becomes."""
    with zipfile.ZipFile(tmp_path / "b.zip", "w", method) as archive:
        archive.writestr("b.kicad_pcb", bytes(100_000_000))
    data = bytearray((tmp_path / "b.zip").read_bytes())
    for mark, place in ((b"PK\x03\x04", 22), (b"PK\x01\x02", 24)):
        size = data.index(mark) + place
        data[size : size + 4] = (100).to_bytes(4, "little")
    (tmp_path / "b.zip").write_bytes(bytes(data))
    usual = method == zipfile.ZIP_DEFLATED
    words = "the archive is damaged" if usual else "is packed by a method that is not read here"
    assert words in refused(tmp_path / "b.zip")


def test_the_jobs_in_an_archive_of_many_files_are_looked_for_once(tmp_path: Path) -> None:
    write_zip({**{f"notes/{number}.txt": "" for number in range(500)}, "b.xml": ipc2581(CARD)}, tmp_path / "b.zip")
    with patch("boards.parts_table.order.roots_of", wraps=roots_of) as looked:
        assert load_board(tmp_path / "b.zip").components[0].name == "U1"
    assert looked.call_count == 1


def test_ten_gigabytes_promised_in_a_header_are_not_believed(tmp_path: Path) -> None:
    header = member("job/steps/card/profile")
    header.size = 10_000_000_000
    parts = [tarfile.TarInfo("job/matrix/matrix")]
    parts[0].size = len(JOB["matrix/matrix"])
    body = parts[0].tobuf() + JOB["matrix/matrix"].encode().ljust(512 * (-(-parts[0].size // 512)), b"\0")
    (tmp_path / "b.tgz").write_bytes(gzip.compress(body + header.tobuf(tarfile.GNU_FORMAT) + bytes(1024)))
    assert "unpacks to more than 100 times its size" in refused(tmp_path / "b.tgz")
    write_zip(JOB, tmp_path / "b.zip")
    data = bytearray((tmp_path / "b.zip").read_bytes())
    size = data.index(b"PK\x01\x02") + 24  # of the first member in the directory
    data[size : size + 4] = (4_000_000_000).to_bytes(4, "little")
    (tmp_path / "b.zip").write_bytes(bytes(data))
    assert "at most 400,000,000 are" in refused(tmp_path / "b.zip")


@pytest.mark.parametrize("cut", [0.2, 0.6, 0.95])
def test_archives_that_end_too_early_are_one_sentence(cut: float, tmp_path: Path) -> None:
    write_tgz(JOB, tmp_path / "b.tgz")
    write_zip(JOB, tmp_path / "b.zip")
    for name in ("b.tgz", "b.zip"):
        data = (tmp_path / name).read_bytes()
        (tmp_path / name).write_bytes(data[: int(len(data) * cut)])
        refused(tmp_path / name)


def test_a_header_of_members_without_end_is_refused(tmp_path: Path) -> None:
    end = b"PK\x05\x06" + bytes(4) + b"\xff\xff\xff\xff" + (500_000_000).to_bytes(4, "little") + bytes(6)
    (tmp_path / "b.zip").write_bytes(bytes(1000) + end)
    assert "more than 100,000 files" in refused(tmp_path / "b.zip")


ENTITIES = '<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa">' + "".join(
    f'<!ENTITY {chr(98 + n)} "{f"&{chr(97 + n)};" * 10}">' for n in range(9)
)
OUTSIDE = '<!DOCTYPE x [<!ENTITY a SYSTEM "/etc/passwd">]>'
TOP = "steps/card/layers/comp_+_top/components"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text.replace("<IPC-2581", f"{ENTITIES}]><IPC-2581", 1), "declares entities"),
        (lambda text: text.replace("<IPC-2581", f"{OUTSIDE}<IPC-2581", 1), "declares entities"),
        (lambda text: text.replace("<Step ", "<a>" * 60 + "<Step ", 1), "nested more than 40 deep"),
        (lambda text: text.replace("<Step ", "<Step x='" + "y" * 40_000_000 + "' ", 1), "more than 16 MB"),
        (lambda text: text.replace('units="MILLIMETER"', 'units="CUBIT"'), "units of <CadHeader> is 'CUBIT'"),
        (lambda text: text.replace("Profile>", "Nothing>"), "edge of the board is missing"),
        (lambda text: text.replace('x="30.0000000"', 'x="1e308"', 1), "must be a number from -10000 to 10000"),
        (lambda text: text.replace('packageRef="Box-U1_4x3mm" part', 'packageRef="other" part'), "file lacks"),
        (lambda text: text.replace("IPC-2581", "svg"), "not an IPC-2581 file"),
        (lambda text: text[:-200], "not valid XML"),
    ],
)  # fmt: skip
def test_damaged_ipc_2581_is_one_sentence(change: Callable[[str], str], words: str, tmp_path: Path) -> None:
    text = change(ipc2581(CARD))
    (tmp_path / "b.xml").write_text(text, "utf-8")
    if len(text) > 1_000_000:  # the text itself is larger than the bound
        with pytest.raises(BoardError, match=words):
            load_board(tmp_path / "b.xml")
    else:
        assert words in refused(tmp_path / "b.xml")


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("steps/card/profile", lambda text: text.replace("OS 30", "OS 1e308", 1), "must be a number within"),
        ("steps/card/profile", lambda text: text.replace("OE", "", 1), "does not end with OE"),
        ("steps/card/profile", lambda _: "UNITS=CUBIT\n", "unit 'CUBIT' is not known"),
        ("steps/card/profile", lambda _: "", "no board outline"),
        ("matrix/matrix", lambda text: text.replace("}", "", 99), "does not end"),
        ("matrix/matrix", lambda _: "", "no step of the job has a profile"),
        (TOP, lambda text: text.replace("CMP 0", "CMP 7"), "which eda/data lacks"),
        (TOP, lambda text: text.replace("CMP 0", "CMP -1"), "whole number"),
        ("steps/card/eda/data", lambda text: text.replace("PIN 1 S", "PIN"), "must be a number"),
    ],
)  # fmt: skip
def test_damaged_odb_is_one_sentence(name: str, change: Callable[[str], str], words: str, tmp_path: Path) -> None:
    write_folder({**JOB, name: change(JOB[name])}, tmp_path / "job")
    assert words in refused(tmp_path / "job")


def packed_job(folder: Path, names: Iterable[str]) -> Path:
    """A job some of whose files are packed by ``compress``."""
    write_folder({name: text for name, text in JOB.items() if name not in names}, folder)
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.Z").write_bytes(compress_lzw(JOB[name].encode()))
    return folder


@pytest.mark.parametrize("names", [["steps/card/eda/data"], list(JOB)])
def test_packed_files_of_a_job_are_read(names: list[str], tmp_path: Path) -> None:
    write_folder(JOB, tmp_path / "plain")
    plain, packed = load_board(tmp_path / "plain"), load_board(packed_job(tmp_path / "job", names))
    assert packed.sha256 == plain.sha256
    with zipfile.ZipFile(tmp_path / "job.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for file in (tmp_path / "job").rglob("*.*"):
            if file.is_file():
                archive.write(file, file.relative_to(tmp_path).as_posix())
        for name in JOB.keys() - set(names):
            archive.writestr(f"job/{name}", JOB[name])
    assert load_board(tmp_path / "job.zip").sha256 == plain.sha256


def test_a_plain_file_counts_and_not_the_packed_one_beside_it(tmp_path: Path) -> None:
    write_folder(JOB, tmp_path / "job")
    plain = load_board(tmp_path / "job")
    (tmp_path / "job" / "steps/card/profile.Z").write_bytes(compress_lzw(b"of an older export"))
    assert load_board(tmp_path / "job").sha256 == plain.sha256


@pytest.mark.parametrize("widest", [9, 10, 12, 16])
@pytest.mark.parametrize("clear_every", [0, 700])
def test_what_was_packed_is_unpacked(widest: int, clear_every: int) -> None:
    numbers = np.random.default_rng(1)
    for data in (b"", b"a", b"ab" * 3000, numbers.bytes(8000), repr(numbers.integers(99, size=900).tolist()).encode()):
        packed = compress_lzw(data, widest, clear_every)
        assert unpack_lzw(packed, len(data)) == data
        assert unpack_lzw(packed, len(data) - 1) is None or not data


@given(st.binary(max_size=60), st.sampled_from([0x89, 0x90, 0x10]))
def test_any_bytes_are_unpacked_or_refused(codes: bytes, flags: int) -> None:
    with suppress(ValueError):
        unpacked = unpack_lzw(bytes([0x1F, 0x9D, flags]) + codes, 10_000)
        assert unpacked is not None
        assert len(unpacked) < 10_000


def test_a_packed_file_that_unpacks_without_end_is_refused(tmp_path: Path) -> None:
    write_folder(JOB, tmp_path / "job")
    (tmp_path / "job" / "steps/card/eda/data").rename(tmp_path / "data")
    place = tmp_path / "job" / "steps/card/eda/data.Z"
    place.write_bytes(compress_lzw(b" " * 60_000))
    assert place.stat().st_size < 500
    with patch("boards.formats.archive._SMALL_BYTES", 50_000):
        assert "unpacks to more than 100 times its size" in refused(tmp_path / "job")
    place.write_bytes(b"\x1f\x9d\x90\xff\xff\xff")
    assert "damaged: a .Z file has a code that is not defined yet" in refused(tmp_path / "job")
    for head in (b"\x1f\x8b\x08", b"\x1f\x9d\x88", b"\x1f\x9d\x91"):  # not .Z, codes of 8 bits, codes of 17
        place.write_bytes(head)
        assert "damaged: a .Z file has another head" in refused(tmp_path / "job")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text.replace("%FSLAX46Y46*%", ""), "stands before the format"),
        (lambda text: text.replace("%FSLAX46Y46*%", "%FSLIX46Y46*%"), "must be absolute"),
        (lambda text: text.replace("X30000000", "X99999999999"), "farther than 10 m"),
        (lambda text: text.replace("%ADD10C,0.1*%", "%AMA*21,1,9xx9xx9xx9,1,0,0,0*%%ADD10A*%"), "cannot be"),
        (lambda text: text.replace("%ADD10C,0.1*%", "%ADD10Q,1*%"), "is not defined"),
        (lambda text: text.replace("M02*", "D99*X1Y1D03*"), "D99 is not defined"),
        (lambda _: "%TF.FileFunction,Profile,NP*%hello", "not read"),
        (lambda text: text.replace("X30000000Y20000000D01*", ""), ""),
        (lambda text: text[: text.index("D01*") + 4], "outline"),
    ],
)  # fmt: skip
def test_damaged_gerber_is_one_sentence(change: Callable[[str], str], words: str, tmp_path: Path) -> None:
    (tmp_path / "b.gbr").write_text(change(gerber_profile(CARD)), "utf-8")
    try:
        load_board(tmp_path / "b.gbr")
    except BoardError:
        assert words in refused(tmp_path / "b.gbr")
    else:
        assert not words


def test_a_folder_or_an_archive_without_a_board_is_one_sentence(tmp_path: Path) -> None:
    folder = tmp_path / "empty"
    folder.mkdir()
    assert "holds no files: name the folder" in refused(folder)
    write_zip({"a.xml": "<a/>", "b.xml": "<a/>"}, tmp_path / "b.zip")
    assert "no Gerber layer that is the board's profile, and no other file of a board, only .xml" in refused(
        tmp_path / "b.zip"
    )
    (tmp_path / "c.zip").write_bytes(os.urandom(100))
    assert "damaged" in refused(tmp_path / "c.zip")


@pytest.mark.parametrize("name", ["a.zip", "a.tgz", "a.xml", "a"])
def test_what_the_system_refuses_is_no_damage_of_an_archive(name: str, tmp_path: Path) -> None:
    file = tmp_path / name
    if name == "a.xml":
        file.write_text(ipc2581(CARD), "utf-8")
    else:
        {"a.zip": write_zip, "a.tgz": write_tgz, "a": write_folder}[name](JOB, file)
    load_board(file)

    class Broken(io.FileIO):
        def readinto(self, buffer: object, /) -> int:
            raise OSError(errno.EIO, os.strerror(errno.EIO))

    def list_folder(folder: Path) -> Iterator[Path]:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    with patch("specs.input_file.io.FileIO", Broken), patch.object(Path, "iterdir", list_folder):
        assert refused(file) == f"{file}: cannot be read: Input/output error"


def test_a_zip_with_a_password_and_a_name_that_no_file_can_have_are_refused(tmp_path: Path) -> None:
    file, long = tmp_path / "job.zip", tmp_path / "long.zip"
    write_zip(JOB, file)
    content = bytearray(file.read_bytes())
    for mark, flags in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        at = -1
        while (at := content.find(mark, at + 1)) >= 0:
            content[at + flags] |= 1
    file.write_bytes(content)
    assert "needs a password. Pack the board without one." in refused(file)
    write_zip({f"{90 * chr(0x57FA)}.kicad_pcb": "(kicad_pcb)"}, long)
    assert "which is too long for a file" in refused(long)


def test_other_members_of_an_archive_may_need_a_password_or_have_long_names(tmp_path: Path) -> None:
    """A program of another system packs a data sheet as it likes: it is not read."""
    file, sheet, long = tmp_path / "job.zip", "sheet.pdf", f"{90 * chr(0x57FA)}.pdf"
    write_zip({**JOB, sheet: "text", long: "text"}, file)
    content = bytearray(file.read_bytes())
    content[content.find(sheet.encode()) - 30 + 6] |= 1
    content[content.rfind(sheet.encode()) - 46 + 8] |= 1
    file.write_bytes(content)
    assert [each.name for each in load_board(file).components] == ["U1"]


def test_what_is_no_archive_is_named_for_what_it_is(tmp_path: Path) -> None:
    empty, loop = tmp_path / "e.zip", tmp_path / "loop"
    empty.write_bytes(b"")
    loop.mkdir()
    (loop / "x").symlink_to("x")
    for path, reason in ((empty, "it is no archive of its kind, or cut short"), (loop, "holds no files")):
        result = washboard("board", "show", path)
        assert (result.code, reason in result.err) == (2, True), result.err
    with zipfile.ZipFile(tmp_path / "c.zip", "w") as archive:
        archive.writestr("a.kicad_pcb", "(kicad_pcb)")
    data = bytearray((tmp_path / "c.zip").read_bytes())
    data[8] = data[data.index(b"PK\x01\x02") + 10] = 99
    (tmp_path / "c.zip").write_bytes(data)
    assert "packed by a method that is not read here" in washboard("board", "show", tmp_path / "c.zip").err
