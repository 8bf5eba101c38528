"""What a foreign library may do to a child process: each as a reader; the child imports this file."""

import ctypes
import os
import sys
import time


def echo(data: bytes) -> bytes:
    sys.stdout.write("\x1b[31mfound nothing odd\x1b[0m\n")
    sys.stdout.flush()
    return data[::-1]


def wait_for_ever(data: bytes) -> bytes:
    time.sleep(3600)
    return data


def count_for_ever(data: bytes) -> bytes:
    while True:
        data = data[::-1]


def fill_memory(data: bytes) -> bytes:
    return b"".join(data * 100_000_000 for _ in range(1000))


def crash(data: bytes) -> bytes:
    ctypes.string_at(0)
    return data


def stop(data: bytes) -> bytes:
    os._exit(3)


def fail(data: bytes) -> bytes:
    raise ValueError("edge 7\x1b[2J is no edge")


def refuse(data: bytes) -> bytes:
    raise SystemExit("it is no picture")


REASONS = {
    wait_for_ever: "its reader took more than 3 s",
    count_for_ever: "its reader took more than 1 s of processor time",
    fill_memory: "its reader needed too much memory",
    crash: "its reader crashed or needed too much memory",
    stop: "its reader crashed or needed too much memory",
    fail: "ValueError: edge 7\\x1b[2J is no edge",
    refuse: "it is no picture",
}
