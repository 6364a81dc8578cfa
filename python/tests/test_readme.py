"""The example of the README, types, and the documentation of the package."""

from __future__ import annotations

import doctest
import subprocess
import sys
from pathlib import Path

import foldpath as fp
import pytest

HERE = Path(__file__).parents[1]


def test_the_example_of_the_readme_runs(tmp_path: Path) -> None:
    readme = (HERE / "README.md").read_text()
    example = readme.split("```python\n")[1].split("```")[0]
    done = subprocess.run([sys.executable, "-c", example], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("planned ") and "holds" in done.stdout
    assert (tmp_path / "path.fold").exists() and (tmp_path / "path.glb").exists()


def test_the_example_of_the_package_runs() -> None:
    failed, tried = doctest.testmod(fp)
    assert tried > 0 and failed == 0


def test_everything_public_is_described() -> None:
    for name in fp.__all__:
        value = getattr(fp, name)
        assert value.__doc__, name
        members = vars(value).items() if isinstance(value, type) else ()
        for member, found in members:
            if not member.startswith("_") and (callable(found) or isinstance(found, property)):
                assert found.__doc__, f"{name}.{member}"


@pytest.mark.full
def test_types_are_strict() -> None:
    pytest.importorskip("mypy")
    package = Path(fp.__file__).parent
    use = HERE / "tests" / "typed.py"
    command = [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", "--cache-dir"]
    command += [str(package / ".mypy"), str(package), str(use)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=package.parent)
    assert done.returncode == 0, done.stdout + done.stderr
