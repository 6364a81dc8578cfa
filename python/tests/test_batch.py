"""Many designs: processes of their own, and in this process."""

from __future__ import annotations

import json
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import foldpath as fp
import pytest
from many_designs import by_command, chunks, designs, plan_chunk


def test_results_are_those_of_the_command(tmp_path: Path) -> None:
    given = designs(60)
    expected = by_command(tmp_path, given)
    assert [json.loads(line)["id"] for line in expected] == [design["id"] for design in given]
    assert plan_chunk(given) == expected
    told = list(fp.batch(given, jobs=2, stable=True))
    assert told == [json.loads(line) for line in expected]
    assert sum("error" in result for result in told) == 1
    results = tmp_path / "results-python.jsonl"
    for _ in range(2):
        run = fp.batch(tmp_path / "designs.jsonl", results, jobs=1, stable=True, resume=True)
        assert list(run) == []
    assert results.read_text().splitlines() == expected
    parts = [
        line for part in range(2) for line in fp.batch(given, shard=f"{part}/2", jobs=1, stable=True)
    ]
    assert sorted(parts, key=lambda result: result["id"]) == told


def test_patterns_are_designs_and_errors_are_retried(tmp_path: Path) -> None:
    pattern = fp.miura(3, 3)
    given = [{"id": "array", "pattern": pattern}, {"id": "missing", "pattern": str(tmp_path / "late.fold")}]
    found, missing = fp.batch(given, stable=True)
    assert found["outcome"] == "planned" and found["design"] == {"pattern": pattern.to_dict()}
    assert found["figures"]["largest_angle"] == pytest.approx(162) and missing["design"] == {"pattern": given[1]["pattern"]}
    results = tmp_path / "results.jsonl"
    list(fp.batch(given, results, stable=True))
    pattern.save(tmp_path / "late.fold")
    list(fp.batch(given, results, stable=True, retry_errors=True))
    again = [json.loads(line) for line in results.read_text().splitlines()]
    assert again[0] == found and again[1]["id"] == "missing" and again[1]["outcome"] == "planned"


def test_a_pool_of_processes_gives_the_same_bytes(tmp_path: Path) -> None:
    given = designs(40)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        lines = [line for lines in pool.map(plan_chunk, chunks(given, 10)) for line in lines]
    assert lines == by_command(tmp_path, given)


def test_a_run_that_cannot_begin_is_refused(tmp_path: Path) -> None:
    with pytest.raises(fp.FoldpathError, match="missing.jsonl: No such file"):
        list(fp.batch(tmp_path / "missing.jsonl"))
    with pytest.raises(fp.FoldpathError, match="found one design"):
        fp.batch({"id": "a", "generate": {"family": "miura"}})  # type: ignore[arg-type]
    with pytest.raises(fp.FoldpathError, match="--shard"):
        list(fp.batch([], shard="3/3"))

    def broken() -> object:
        yield {"id": "a", "generate": {"family": "resch"}}
        raise KeyError("as it should")

    with pytest.raises(KeyError):
        list(fp.batch(broken()))  # type: ignore[arg-type]


def test_an_iterator_that_is_left_ends_the_run() -> None:
    for result in fp.batch(designs(1000), jobs=1):
        assert result["outcome"] == "planned"
        break


def test_designs_that_are_no_designs_have_results() -> None:
    assert json.loads(fp.plan_line("{}"))["error"]["message"]
    result = json.loads(fp.plan_line({"id": "a", "generate": {"family": "miura", "rows": 2, "cols": 2}, "plan": {"boud": 1}}))
    design = {"generate": {"family": "miura", "rows": 2, "cols": 2}, "plan": {"boud": 1}}
    assert result == {"id": "a", "design": design, "error": {"file": "", "line": None, "column": None, "message": "unexpected argument '--boud' found", "hint": None}}
