"""Other threads go on while a plan is made, Ctrl-C ends it, and forked processes plan."""

from __future__ import annotations

import multiprocessing
import signal
import subprocess
import sys
import threading
import time
from typing import Any

import foldpath as fp

# A plan that takes minutes: every crease of a large sheet by itself, closed by gradient steps.
OPTIONS: dict[str, Any] = {
    "search": "random",
    "symmetry": "off",
    "reuse": "off",
    "vertices": "all",
    "solver": "gradient",
    "timeout": 200,
}


def test_other_threads_go_on() -> None:
    cancelled = threading.Event()
    counts = []

    def count() -> None:
        while not cancelled.wait(0.001):
            counts.append(1)

    thread = threading.Thread(target=count)
    thread.start()
    fp.plan(fp.miura(24, 24), **{**OPTIONS, "timeout": 0.5})
    cancelled.set()
    thread.join()
    # The lock is held for microseconds; a plan that held it would have left none.
    assert len(counts) > 10


def test_plans_of_several_threads_are_the_same() -> None:
    patterns = [fp.miura(rows, 6) for rows in range(2, 10)]
    alone = [fp.plan(pattern).motion for pattern in patterns]
    found: list[fp.Motion | None] = [None] * len(patterns)

    def work(first: int) -> None:
        for number in range(first, len(patterns), 2):
            found[number] = fp.plan(patterns[number]).motion

    threads = [threading.Thread(target=work, args=(first,)) for first in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for one, other in zip(alone, found):
        assert one is not None and other is not None
        assert one._path.text() == other._path.text()


def test_ctrl_c_ends_a_plan() -> None:
    code = f"""
import foldpath as fp
print("ready", flush=True)
try:
    fp.plan(fp.miura(24, 24), **{OPTIONS})
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.5)
    assert process.poll() is None
    process.send_signal(signal.SIGINT)
    assert process.stdout.readline() == "interrupted\n"
    # The thread that planned does not keep the process.
    assert process.wait(20) == 0


def _outcome(rows: int) -> str:
    return fp.plan(fp.miura(rows, rows), symmetry="off").outcome


def test_forked_processes_plan_after_their_parent_has() -> None:
    # Large enough for threads to share the work, so that their pool exists in the parent.
    assert _outcome(24) == "planned"
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map(_outcome, [24, 23]) == ["planned"] * 2
