"""Measures plans from Python: python benchmark.py [PATTERN.fold]

Prints the time from the bytes of a pattern to the arrays of its motion, the time of the parts, how long a plan goes on
after Ctrl-C, and how many plans two threads make in the time of one. Times are the best and the median of many.
"""

from __future__ import annotations

import os
import signal
import statistics
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import foldpath as fp

RUNS = 300


def measured(work: Callable[[], object], runs: int = RUNS) -> str:
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        work()
        times.append(1e3 * (time.perf_counter() - start))
    return f"{min(times):7.3f} ms best, {statistics.median(times):7.3f} ms median of {runs}"


def rate(data: bytes, threads: int, seconds: float = 2.0) -> float:
    """Return the number of plans a second that this many threads make."""
    counts = [0] * threads
    end = time.perf_counter() + seconds

    def work(thread: int) -> None:
        while time.perf_counter() < end:
            arrays(data)
            counts[thread] += 1

    workers = [threading.Thread(target=work, args=(thread,)) for thread in range(threads)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    return sum(counts) / seconds


def arrays(data: bytes) -> object:
    motion = fp.plan(fp.read(data)).motion
    assert motion is not None
    return motion.times, motion.fold_angles


def interrupted() -> str:
    """Return how long a plan that takes minutes goes on after Ctrl-C."""
    times = []
    for number in range(10):
        sent = []

        def send() -> None:
            sent.append(time.perf_counter())
            os.kill(os.getpid(), signal.SIGINT)

        timer = threading.Timer(0.1 + 0.2 * number, send)
        timer.start()
        try:
            fp.plan(fp.miura(24, 24), search="random", symmetry="off", reuse="off", vertices="all", solver="gradient")
        except KeyboardInterrupt:
            times.append(1e3 * (time.perf_counter() - sent[0]))
    return f"{max(times):7.3f} ms at most, of {len(times)}"


def main() -> None:
    default = Path(__file__).parents[1] / "patterns" / "miura-11x11.fold"
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else default
    data = path.read_bytes()
    pattern = fp.read(data)
    plan = fp.plan(pattern)
    motion = plan.motion
    assert motion is not None
    print(f"{path.name}: {pattern}, {motion}")
    print("bytes to arrays     ", measured(lambda: arrays(data)))
    print("  read              ", measured(lambda: fp.read(data)))
    print("  plan              ", measured(lambda: fp.plan(pattern)))
    print("  arrays            ", measured(lambda: (motion.times, motion.fold_angles)))
    print("to_dict             ", measured(plan.to_dict))
    print("positions, 100 times", measured(lambda: motion.vertices(motion.duration / 99 * hundred), 50))
    print("Ctrl-C              ", interrupted())
    one, two = (rate(data, threads) for threads in (1, 2))
    print(f"plans a second: {one:.0f} by one thread, {two:.0f} by two: {two / one:.2f} times as many")


if __name__ == "__main__":
    import numpy as np

    hundred = np.arange(100)
    main()
