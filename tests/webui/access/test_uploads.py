"""Limits of uploads, counted while they arrive."""

import pytest

from webui.access.access import UploadError, Uploads

MB = 1_000_000
PART = 512 * 1024


@pytest.fixture
def uploads() -> Uploads:
    return Uploads(200 * MB, "/project")


@pytest.mark.parametrize(
    ("size", "parts"), [(0, 0), (1, 1), (PART, 1), (PART + 1, 2), (200 * MB, -(-200 * MB // PART))]
)
def test_files_of_a_sensible_size_begin(uploads: Uploads, size: int, parts: int) -> None:
    uploads.begin(0, "t", "board.step", size, parts)


@pytest.mark.parametrize("size", [200 * MB + 1, 10**12, 2**63, 10**30])
def test_what_is_too_large_is_refused_before_it_arrives(uploads: Uploads, size: int) -> None:
    with pytest.raises(UploadError, match=r"'board\.step': [\d,]+ MB are too many to upload; copy it into /project\."):
        uploads.begin(0, "t", "board.step", size, -(-size // PART))


@pytest.mark.parametrize(("size", "parts"), [(1, 0), (0, 1), (-1, 1), (1, -1), (1, 2), (MB, 10**9), (100 * MB, 10**6)])
def test_what_contradicts_itself_is_refused(uploads: Uploads, size: int, parts: int) -> None:
    with pytest.raises(UploadError, match=r"'a\.tri': .* cannot be; upload it again\."):
        uploads.begin(0, "t", "a.tri", size, parts)


SIZE, PARTS = 100_000, 2


@pytest.mark.parametrize(
    "sent",
    [
        [(0, b"x" * (SIZE + 1))],
        [(0, b"x" * SIZE), (1, b"x")],
        [(0, b"x"), (2, b"")],
        [(-1, b"")],
        [(10**12, b"x")],
        [(0, "text")],
        [(0, 5)],
    ],
    ids=str,
)
def test_more_than_was_announced_is_refused(uploads: Uploads, sent) -> None:
    uploads.begin(0, "t", "a.tri", SIZE, PARTS)
    *good, bad = sent
    for part, content in good:
        uploads.receive(0, "t", part, content)
    with pytest.raises(UploadError):
        uploads.receive(0, "t", *bad)


def test_a_part_that_comes_twice_counts_once(uploads: Uploads) -> None:
    uploads.begin(0, "t", "a.tri", SIZE, PARTS)
    for _ in range(5):
        uploads.receive(0, "t", 0, b"x" * (SIZE - 1))
    uploads.receive(0, "t", 1, b"x")


def test_a_page_has_few_uploads_under_way(uploads: Uploads) -> None:
    for number in range(4):
        uploads.begin(0, f"t{number}", "a.tri", 1, 1)
    with pytest.raises(UploadError, match="4 uploads are under way"):
        uploads.begin(0, "t4", "a.tri", 1, 1)
    uploads.begin(1, "t0", "a.tri", 1, 1)  # another page
    uploads.keep(0, {"t0", "t1"})  # the others are complete
    uploads.begin(0, "t4", "a.tri", 1, 1)


def test_the_same_name_twice_is_refused(uploads: Uploads) -> None:
    uploads.begin(0, "t", "a.tri", 1, 1)
    with pytest.raises(UploadError):
        uploads.begin(0, "t", "a.tri", 1, 1)


def test_all_pages_together_hold_at_most_two_of_the_largest_files() -> None:
    uploads = Uploads(SIZE, "/project")
    for client in range(3):
        uploads.begin(client, "t", "a.tri", SIZE, PARTS)
        if client < 2:
            uploads.receive(client, "t", 0, b"x" * SIZE)
    with pytest.raises(UploadError, match="too much is uploaded at once"):
        uploads.receive(2, "t", 0, b"x")
    uploads.forget(0)
    uploads.begin(2, "u", "a.tri", SIZE, PARTS)
    uploads.receive(2, "u", 0, b"x" * SIZE)


def test_what_was_not_announced_is_refused(uploads: Uploads) -> None:
    with pytest.raises(UploadError, match="not announced"):
        uploads.receive(0, "t", 0, b"x")
    with pytest.raises(UploadError, match="without a name"):
        uploads.begin(0, "t", 5, 1, 1)  # type: ignore[arg-type]
