"""Many designs."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterable, Iterator, Mapping
from typing import IO, Any, Union

from . import _foldpath
from ._convert import File, to_json
from ._error import FoldpathError
from ._pattern import Pattern

#: The command that starts the command line once more.
PROGRAM = [sys.executable, "-m", "foldpath"]

Design = Union[Mapping[str, Any], str]


def plan_line(design: Design, *, timeout: float = 60.0, stable: bool = False) -> str:
    """Plan one design in this process, and return its result in one line, as ``foldpath batch`` writes it.

    ``design`` is a dictionary or a line of JSON, as :func:`batch` takes them. ``timeout`` (seconds) holds for a design
    that names none. With ``stable``, what depends on the clock is left out. A design that cannot be planned has an
    ``error`` in its result; only a crash of the process would end more than the design. This is the function for chunks
    of designs in Ray, Dask or a pool of processes, whose workers are processes already.
    """
    return _foldpath.plan_line(_line(design), timeout, stable)


def batch(
    designs: Union[File, Iterable[Design]],
    output: File | None = None,
    *,
    jobs: int | None = None,
    shard: str | None = None,
    resume: bool = False,
    retry_errors: bool = False,
    timeout: float = 60.0,
    stable: bool = False,
) -> Iterator[dict[str, Any]]:
    """Plan many designs in processes of their own, as ``foldpath batch`` does, with its options.

    ``designs`` is a file of JSON lines, or dictionaries such as ``{"id": "a", "generate": {"family": "miura", "rows": 3,
    "columns": 3}, "plan": {"bound": 1e-3}}``; ``"pattern"`` may be a file, a dictionary in the form of FOLD, or a
    :class:`Pattern`. Each result carries its design and figures by which designs are ranked. Results come in the order of the designs: with ``output`` they are written to
    that file and the iterator is empty; otherwise the iterator has them, as dictionaries, while the others are planned.
    A design that cannot be read, ends its process or hangs is a result with an ``error``.

    Raises :class:`FoldpathError` if the run cannot begin, or cannot go on.
    """
    if isinstance(designs, Mapping):
        raise FoldpathError("expected a file or an iterable of designs, found one design: put it in a list")
    is_file = isinstance(designs, (str, os.PathLike))
    arguments = [*PROGRAM, "batch", os.fspath(designs) if is_file else "-"]  # type: ignore[arg-type]
    arguments += ["-o", "-" if output is None else os.fspath(output)]
    arguments += ["--quiet", f"--timeout={timeout}"]
    if jobs is not None:
        arguments.append(f"--jobs={jobs}")
    if shard is not None:
        arguments.append(f"--shard={shard}")
    arguments += ["--resume"] * resume + ["--retry-errors"] * retry_errors + ["--stable"] * stable
    results = _run(arguments, None if is_file else designs)  # type: ignore[arg-type]
    if output is None:
        return results
    # All results go to the file, so that this runs to the end and has none.
    return iter(list(results))


def _run(arguments: list[str], designs: Iterable[Design] | None) -> Iterator[dict[str, Any]]:
    """Run a batch and yield the lines of its stdout."""
    with tempfile.TemporaryFile() as errors:
        process = subprocess.Popen(
            arguments,
            stdin=subprocess.DEVNULL if designs is None else subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            # A group of its own, so that its workers end with it.
            start_new_session=True,
        )
        feeder = _Feeder(designs or [], process.stdin)
        try:
            feeder.start()
            assert process.stdout is not None
            for line in process.stdout:
                if line.startswith(b'{"id":'):
                    yield json.loads(line)
            status = process.wait()
        finally:
            # The iterator may be left before its end, by Ctrl-C as well.
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            if process.stdout is not None:
                process.stdout.close()
            # An iterator that waits for something is not waited for.
            feeder.join(1.0)
        if feeder.failure is not None:
            raise feeder.failure
        if status != 0:
            errors.seek(0)
            text = errors.read().decode(errors="replace").strip()
            raise FoldpathError(text.removeprefix("foldpath: ") or f"the batch ended ({status})")


class _Feeder(threading.Thread):
    """Writes designs to a batch, which reads them as it plans."""

    def __init__(self, designs: Iterable[Design], stream: IO[bytes] | None) -> None:
        super().__init__(daemon=True)
        self.designs = designs
        self.stream = stream
        self.failure: BaseException | None = None

    def run(self) -> None:
        if self.stream is None:
            return
        try:
            with self.stream:
                for design in self.designs:
                    self.stream.write(_line(design).encode() + b"\n")
        except BrokenPipeError:
            # The batch has ended; its exit status says why.
            pass
        except BaseException as failure:
            self.failure = failure


def _line(design: Design) -> str:
    if isinstance(design, str):
        return design.strip()
    pattern = design.get("pattern")
    if isinstance(pattern, Pattern):
        design = {**design, "pattern": pattern.to_dict()}
    return to_json(design)
