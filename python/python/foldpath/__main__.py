"""The command ``foldpath``."""

from __future__ import annotations

import signal
import sys

from . import _foldpath
from ._batch import PROGRAM


def main() -> None:
    """Run the command line and end the process with its exit status."""
    # Ctrl-C ends the command at once, as it does without Python.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_foldpath.main(["foldpath", *sys.argv[1:]], PROGRAM))


if __name__ == "__main__":
    main()
