"""Designs for tests of batches, and what the command makes of them. Workers of pools import this module."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import foldpath as fp


def designs(count: int) -> list[dict]:
    """Return Miura designs of several angles and sizes; every 50th is broken."""
    return [
        {
            "id": f"design-{number:04}",
            "generate": {
                "family": "miura",
                "rows": 2 + number % 5,
                "cols": 2 + number % 4,
                "angle": 0 if number % 50 == 49 else 40 + number % 45,
            },
            "plan": {"max_accel": 90 + number % 3},
        }
        for number in range(count)
    ]


def by_command(folder: Path, given: list[dict]) -> list[str]:
    """Return the results of the command, line by line."""
    files = [folder / name for name in ("designs.jsonl", "results.jsonl")]
    files[0].write_text("".join(json.dumps(design) + "\n" for design in given))
    words = [sys.executable, "-m", "foldpath", "batch", *map(str, files[:1]), "-o", str(files[1])]
    subprocess.run([*words, "--stable", "--quiet"], check=True, stdout=subprocess.DEVNULL)
    return files[1].read_text().splitlines()


def plan_chunk(chunk: list[dict]) -> list[str]:
    return [fp.plan_line(design, stable=True) for design in chunk]


def chunks(given: list[dict], size: int) -> list[list[dict]]:
    return [given[first : first + size] for first in range(0, len(given), size)]
