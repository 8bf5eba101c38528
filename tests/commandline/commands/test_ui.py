"""``washboard ui`` as it is started and ended from a terminal."""

import re
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request

import pytest
from waiting import WAIT_S

pytestmark = pytest.mark.slow


def start(folder, *options):
    command = [sys.executable, "-m", "washboard", "ui", "tiny", "rinse-only", *options]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def read_until_ready(process):
    lines = []
    for line in process.stdout:
        lines.append(line)
        if "Ctrl-C" in line:
            return "".join(lines)
    raise AssertionError(process.stderr.read())


def end(process):
    time.sleep(0.5)  # an interrupt in the middle of a line would have it printed twice
    process.send_signal(signal.SIGINT)
    out, errors = process.communicate(timeout=WAIT_S)
    assert process.returncode == 0
    assert out == "Stopped.\n"
    assert errors == ""


def test_it_says_where_the_page_is_serves_it_and_ends_quietly(tmp_path):
    process = start(tmp_path, "--port", "8180")
    said = read_until_ready(process)
    url, token = re.search(r"(http://127\.0\.0\.1:\d+/)\?token=(\S+)", said).groups()
    with pytest.raises(urllib.error.HTTPError, match="403"):
        urllib.request.urlopen(url)
    browser = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    for address in (f"{url}?token={token}", url):
        with browser.open(address) as answer:
            assert answer.url == url
            assert b"<html" in answer.read(2000).lower()
    assert "read and write" not in said
    end(process)


def test_without_a_token_it_says_what_that_gives_up(tmp_path):
    process = start(tmp_path, "--no-token")
    said = read_until_ready(process)
    with urllib.request.urlopen(re.search(r"http://127\.0\.0\.1:\d+", said)[0]) as answer:
        assert b"<html" in answer.read(2000).lower()
    end(process)
    assert f"Every user of this machine can read and write {tmp_path.resolve()}." in said
    assert "?token=" not in said


def test_a_port_in_use_is_named_with_the_one_that_was_taken_instead(tmp_path):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        process = start(tmp_path, "--port", str(port))
        said = read_until_ready(process)
        end(process)
    assert f"Port {port} is in use" in said
    assert f":{port}/" not in said.split("Washboard is at")[1]


def test_a_page_for_everybody_says_so(tmp_path):
    process = start(tmp_path, "--host", "0.0.0.0", "--port", "8180")
    said = read_until_ready(process)
    end(process)
    assert f"whoever has this address with its token can read and write {tmp_path.resolve()}" in said
    assert "http://127.0.0.1:" in said


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--host", "203.0.113.9"), "host '203.0.113.9'"),
        (("--folder", "nowhere"), "nowhere"),
        (("--no-token", "--host", "0.0.0.0"), "leave out one of --host and --no-token"),
        (("--port", "70000"), "--port"),
    ],
)
def test_what_cannot_be_is_one_clear_error(tmp_path, options, reason):
    process = start(tmp_path, *options)
    out, errors = process.communicate(timeout=WAIT_S)
    assert process.returncode == 2
    assert out == ""
    assert errors.startswith("error: ")
    assert reason in errors
    assert errors.count("\n") == 1


def test_a_cell_that_there_is_not_is_named_and_nothing_is_served(tmp_path):
    process = start(tmp_path, "--cell", "nope")
    out, errors = process.communicate(timeout=WAIT_S)
    assert process.returncode != 0
    assert "nope" in errors
    assert "ur5e-bench" in errors
    assert "Washboard is at" not in out
