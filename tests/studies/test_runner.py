"""Jobs in processes: each computed once, results kept as they come, whoever is killed."""

import errno
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import nullcontext
from itertools import chain
from pathlib import Path
from types import SimpleNamespace
from typing import cast
from unittest.mock import patch

import pytest
from command import contents
from distributed import Client
from study_work import broken_work, cheap_jobs, computed, slow_work, work

from specs.output_file import OutputError
from specs.progress import no_progress
from studies.errors import StudyError
from studies.fingerprint import program_version
from studies.job import Job, JobResult
from studies.runner import existing_cluster, local_cluster, own_client, run_jobs
from studies.store import open_store

STUDY_OF_ITS_OWN = """
import sys
from pathlib import Path
from study_work import cheap_jobs, slow_work
from studies.runner import existing_cluster, run_jobs
from studies.store import open_store
folder, address = Path(sys.argv[1]), sys.argv[2]
with open_store(folder / "out") as store:
    run_jobs([lambda: cheap_jobs(folder, 60)], store, existing_cluster(address), lambda *_: None, slow_work)
"""


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with local_cluster(2) as found:
        yield found


def kept(folder: Path) -> dict[str, bytes]:
    return contents(folder / "out")


@pytest.mark.slow  # the first of these tests waits for the workers of all
def test_equal_jobs_are_computed_once(client: Client, tmp_path: Path) -> None:
    with open_store(tmp_path / "out") as store:
        count = run_jobs(
            [lambda: chain(cheap_jobs(tmp_path, 5), cheap_jobs(tmp_path, 6)), lambda: cheap_jobs(tmp_path, 7)],
            store,
            nullcontext(client),
            no_progress,
            work,
        )
        assert count == 7
        assert sorted(key for _, key in computed(tmp_path)) == sorted(job.key for job in cheap_jobs(tmp_path, 7))
        for job in cheap_jobs(tmp_path, 7):
            assert store.find(job.key) == work(job)


@pytest.mark.slow
def test_what_is_kept_is_not_computed_again(client: Client, tmp_path: Path) -> None:
    with open_store(tmp_path / "out") as store:
        run_jobs([lambda: cheap_jobs(tmp_path, 4)], store, nullcontext(client), no_progress, work)
        before = kept(tmp_path)
        assert run_jobs([lambda: cheap_jobs(tmp_path, 6)], store, nullcontext(client), no_progress, work) == 2
    assert before.items() <= kept(tmp_path).items()
    keys = [key for _, key in computed(tmp_path)]
    assert len(keys) == len(set(keys)) == 6


@pytest.mark.slow
def test_few_jobs_are_submitted_at_a_time(client: Client, tmp_path: Path) -> None:
    given = 0
    ahead: list[int] = []

    def jobs() -> Iterator[Job]:
        nonlocal given
        given = 0
        for job in cheap_jobs(tmp_path, 60):
            given += 1
            yield job

    with open_store(tmp_path / "out") as store:
        keep = store.keep

        def watched(result: JobResult) -> None:
            keep(result)
            ahead.append(given - len(kept(tmp_path)))

        with patch.object(store, "keep", watched):
            run_jobs([jobs], store, nullcontext(client), no_progress, work)
    assert len(ahead) == 60
    assert max(ahead) <= 2 * 2


@pytest.mark.slow
def test_the_last_jobs_are_divided_among_the_workers(client: Client, tmp_path: Path) -> None:
    with open_store(tmp_path / "out") as store:
        run_jobs([lambda: cheap_jobs(tmp_path, 2)], store, nullcontext(client), no_progress, slow_work)
    assert len({process for process, _ in computed(tmp_path)}) == 2


@pytest.mark.slow
def test_a_killed_worker_loses_and_repeats_nothing_that_was_kept(client: Client, tmp_path: Path) -> None:
    killed: list[int] = []

    def kill(_what: str, done: float) -> None:
        if done > 0.3 and not killed:
            killed.append(computed(tmp_path)[0][0])
            os.kill(killed[0], signal.SIGKILL)

    with open_store(tmp_path / "out") as store:
        done_before: list[str] = []
        keep = store.keep

        def watched(result: JobResult) -> None:
            keep(result)
            if not killed:
                done_before.append(result.job)

        with patch.object(store, "keep", watched):
            assert run_jobs([lambda: cheap_jobs(tmp_path, 40)], store, nullcontext(client), kill, slow_work) == 40
    assert killed
    assert len(kept(tmp_path)) == 40
    keys = [key for _, key in computed(tmp_path)]
    assert set(keys) == {job.key for job in cheap_jobs(tmp_path, 40)}
    assert all(keys.count(key) == 1 for key in done_before)


@pytest.mark.slow
def test_a_killed_study_goes_on_to_the_same_bytes(client: Client, tmp_path: Path) -> None:
    address = client.scheduler.address
    paths = os.pathsep.join(path for path in sys.path if path)
    process = subprocess.Popen(
        [sys.executable, "-c", STUDY_OF_ITS_OWN, str(tmp_path), address], env={**os.environ, "PYTHONPATH": paths}
    )
    results = tmp_path / "out" / "results"
    while process.poll() is None and len(list(results.rglob("*.json"))) < 10:
        time.sleep(0.01)
    process.kill()
    assert process.wait() == -signal.SIGKILL
    before = {name: content for name, content in kept(tmp_path).items() if name.endswith(".json")}
    assert 10 <= len(before) < 60
    with open_store(tmp_path / "out") as store:
        assert run_jobs(
            [lambda: cheap_jobs(tmp_path, 60)], store, existing_cluster(address), no_progress, work
        ) == 60 - len(before)
    keys = [key for _, key in computed(tmp_path)]
    assert all(keys.count(Path(name).stem) == 1 for name in before)
    whole = kept(tmp_path)
    assert before.items() <= whole.items()
    fresh = tmp_path / "fresh"
    with open_store(fresh) as store:
        for job in cheap_jobs(tmp_path, 60):
            store.keep(work(job))
    assert contents(fresh) == whole


@pytest.mark.slow
def test_a_defect_of_one_job_is_raised_when_the_others_are_done(client: Client, tmp_path: Path) -> None:
    with open_store(tmp_path / "out") as store:
        with pytest.raises(KeyError, match="board"):
            run_jobs([lambda: cheap_jobs(tmp_path, 9)], store, nullcontext(client), no_progress, broken_work)
        assert len(kept(tmp_path)) == 6


@pytest.mark.slow
def test_a_full_disk_ends_the_study_and_keeps_what_was_done(client: Client, tmp_path: Path) -> None:
    written = 0
    write = os.fsync

    def full(descriptor: int) -> None:
        nonlocal written
        written += 1
        if written > 5:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        write(descriptor)

    with open_store(tmp_path / "out") as store:
        with patch("os.fsync", full), pytest.raises(OutputError, match="No space left on device"):
            run_jobs([lambda: cheap_jobs(tmp_path, 20)], store, nullcontext(client), no_progress, work)
        assert len(kept(tmp_path)) == 5
        assert run_jobs([lambda: cheap_jobs(tmp_path, 20)], store, nullcontext(client), no_progress, work) == 15
    assert len(kept(tmp_path)) == 20


def test_a_scheduler_that_does_not_answer_is_named() -> None:
    with (
        patch("studies.runner._CONNECT_S", 0.2),
        pytest.raises(StudyError, match=r"no scheduler answers at tcp://127\.0\.0\.1:9"),
        existing_cluster("tcp://127.0.0.1:9"),
    ):
        pass


@pytest.mark.parametrize("library", ["distributed", "pyarrow"])
def test_without_the_extra_one_sentence_names_it(library: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(StudyError) as caught, local_cluster(1):
        pass
    assert str(caught.value) == "studies need `pip install washboard[study]`."


@pytest.mark.slow
def test_workers_that_the_system_does_not_let_begin_are_one_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))

    monkeypatch.setattr("distributed.diskutils.WorkSpace._init_workspace", refuse)
    refused = pytest.raises(StudyError, match=r"its workers cannot be started: .*Too many open files. Raise the limits")
    with refused, local_cluster(1):
        pass


@pytest.mark.slow
def test_a_cluster_that_adapts_begins_workers_when_there_are_jobs(tmp_path: Path) -> None:
    from distributed import LocalCluster

    told: list[str] = []
    at_any = "127.0.0.1:0"
    with LocalCluster(
        n_workers=0, threads_per_worker=1, host="127.0.0.1", dashboard_address=at_any, local_directory=str(tmp_path)
    ) as cluster:
        cluster.adapt(minimum=0, maximum=2)
        with open_store(tmp_path / "out") as store:
            at = existing_cluster(cluster.scheduler_address)
            jobs = [lambda: cheap_jobs(tmp_path, 6)]
            assert run_jobs(jobs, store, at, lambda what, _: told.append(what), slow_work) == 6
    assert any("waiting for a worker" in each for each in told)
    assert told[-1] == "6 of 6 jobs, 0 s left"


@pytest.mark.slow
def test_no_lock_of_the_scratch_folder_waits_for_a_failing_disk() -> None:
    from dask import config

    with local_cluster(1) as client:
        scratch = Path(config.get("temporary-directory"))
        assert client.submit(os.getpid).result() != os.getpid()
        assert any(scratch.rglob("worker-*"))
        assert not list(scratch.rglob("*lock*"))


def test_a_client_that_cannot_be_waited_for_is_refused() -> None:
    for asynchronous, status, state in ((True, "running", "asynchronous"), (False, "closed", "closed")):
        given = cast("Client", SimpleNamespace(asynchronous=asynchronous, status=status))
        with pytest.raises(StudyError, match=f"the Dask client is {state}"), own_client(given):
            pass


@pytest.mark.slow
def test_a_client_of_ones_own_is_used_and_stays_open(client: Client, tmp_path: Path) -> None:
    with open_store(tmp_path / "out") as store:
        assert run_jobs([lambda: cheap_jobs(tmp_path, 3)], store, own_client(client), no_progress, work) == 3
    assert client.status == "running"


def test_a_worker_with_other_code_is_named() -> None:
    def run(_what: object, on_error: str) -> dict[str, object]:
        return {"tcp://a": program_version(), "tcp://b": "0.1.0+0000"}

    given = cast("Client", SimpleNamespace(asynchronous=False, status="running", run=run))
    with pytest.raises(StudyError, match=r"tcp://b has Washboard 0\.1\.0\+0000, and this is 0"), own_client(given):
        pass


def test_the_dashboard_needs_bokeh(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("studies.runner.find_spec", lambda name: None if name == "bokeh" else object())
    with pytest.raises(StudyError, match="pip install bokeh"), local_cluster(1, dashboard=True):
        pass


def test_a_folder_that_somebody_else_calls_results_is_no_study(tmp_path: Path) -> None:
    for name, inside in (("a", "results/mine.txt"), ("b", "results/ab/x.json"), ("b", "notes.txt"), ("c", "runs.csv")):
        (tmp_path / name / inside).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name / inside).write_text("mine")
    (tmp_path / "c" / "results").mkdir()
    for name in ("a", "c"):
        before = contents(tmp_path / name)
        with pytest.raises(OutputError, match="holds something else"), open_store(tmp_path / name):
            pass
        assert contents(tmp_path / name) == before
    with open_store(tmp_path / "b"), open_store(tmp_path / "new"):
        pass
