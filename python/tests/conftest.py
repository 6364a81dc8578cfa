"""What the tests share."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import pytest
from foldpath import _foldpath
from foldpath._batch import PROGRAM


class Done(NamedTuple):
    status: int
    out: str
    err: str


Command = Callable[..., Done]


@pytest.fixture
def command(capfd: pytest.CaptureFixture[str]) -> Command:
    """Runs the command line in this process."""

    def run(*arguments: object) -> Done:
        capfd.readouterr()
        status = _foldpath.main(["foldpath", *map(str, arguments)], PROGRAM)
        return Done(status, *capfd.readouterr())

    return run
