"""What is kept of a study: whole and as it was computed, by this program, or computed anew."""

import json
from pathlib import Path

import pytest
from study_work import cheap_jobs, work

from specs.input_file import own_text
from studies.errors import StudyError
from studies.fingerprint import program_version
from studies.store import open_store


@pytest.mark.parametrize(
    ("key", "value"), [("litres", 999.25), ("components", {"U1": "dirty"}), ("verdict", "dirty"), ("sha256", "0" * 64)]
)
def test_a_result_that_was_changed_by_hand_is_none(key: str, value: object, tmp_path: Path) -> None:
    (job,) = cheap_jobs(tmp_path, 1)
    with open_store(tmp_path / "out") as store:
        store.keep(work(job))
        assert store.find(job.key) == work(job)
        (file,) = (tmp_path / "out" / "results").rglob("*.json")
        written = json.loads(file.read_text())
        file.write_text(json.dumps({**written, key: value}))
        assert store.find(job.key) is None
        with pytest.raises(StudyError, match="start the study again"):
            store.read(job.key)
        file.write_text(json.dumps(written))  # only the layout differs
        assert store.find(job.key) == work(job)


@pytest.mark.parametrize("changed", ["gap/hele_shaw.py", "library/default.yaml"])
def test_what_other_code_computed_is_computed_anew(
    changed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def other(package: str, name: str) -> str:
        return own_text(package, name) + (" " if (package, name) == ("cleaning", changed) else "")

    (job,) = cheap_jobs(tmp_path, 1)
    assert job.version == program_version()
    with open_store(tmp_path / "out") as store:
        store.keep(work(job))
        monkeypatch.setattr("studies.fingerprint.own_text", other)
        program_version.cache_clear()
        try:
            (again,) = cheap_jobs(tmp_path, 1)
        finally:
            program_version.cache_clear()
        assert again.version != job.version
        assert again.version.partition("+")[0] == job.version.partition("+")[0]
        assert store.find(again.key) is None
        assert store.find(job.key) is not None
