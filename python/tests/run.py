"""Runs the tests with the extension module that cargo has built: python tests/run.py LIBRARY [ARGUMENTS OF PYTEST]."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent


def main(library: str, arguments: list[str]) -> int:
    with tempfile.TemporaryDirectory() as folder:
        package = Path(folder, "foldpath")
        shutil.copytree(HERE.parent / "python" / "foldpath", package, ignore=shutil.ignore_patterns("__pycache__", "*.so"))
        shutil.copy(library, package / "_foldpath.abi3.so")
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([folder, str(HERE)]), "PYTHONDONTWRITEBYTECODE": "1"}
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir", str(HERE.parent)]
        command += arguments or ["-m", "not full"]
        return subprocess.run([*command, str(HERE)], env=environment, cwd=HERE.parent).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
