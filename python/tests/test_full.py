"""Tests that take long or need more packages: the wheel, the guide, and engines for many designs."""

from __future__ import annotations

import json
import subprocess
import sys
import venv
from pathlib import Path

import pytest
from many_designs import by_command, chunks, designs, plan_chunk

pytestmark = pytest.mark.full

HERE = Path(__file__).parents[1]


@pytest.mark.parametrize(("name", "drawn"), [("guide", 3), ("fit", 1)])
def test_a_notebook_runs_from_start_to_end(name: str, drawn: int) -> None:
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    notebook = nbformat.read(HERE / f"{name}.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    pages = [output for output in outputs if "<iframe" in str(output.get("data", {}).get("text/html"))]
    pictures = [output for output in outputs if "image/png" in output.get("data", {})]
    assert len(pages) == 1 and len(pictures) == drawn


def test_a_wheel_installs_where_there_is_no_rust(tmp_path: Path) -> None:
    wheels = tmp_path / "wheels"
    build = [sys.executable, "-m", "maturin", "build", "--release", "--locked", "--out", str(wheels)]
    subprocess.run([*build, "--manifest-path", str(HERE / "Cargo.toml")], check=True)
    (wheel,) = wheels.glob("foldpath-*-cp310-abi3-*.whl")
    # A wheel beyond this size has something in it that does not belong there.
    assert wheel.stat().st_size < 10e6, wheel.stat().st_size
    print(f"{wheel.name}: {wheel.stat().st_size / 1e6:.1f} MB")
    venv.create(tmp_path / "venv", with_pip=True)
    python = tmp_path / "venv" / "bin" / "python"
    subprocess.run([python, "-m", "pip", "install", "--quiet", wheel], check=True)
    environment = {"PATH": f"{python.parent}:/usr/bin:/bin", "HOME": str(tmp_path)}
    example = (HERE / "README.md").read_text().split("```python\n")[1].split("```")[0]
    done = subprocess.run([python, "-c", example], env=environment, cwd=tmp_path, capture_output=True, text=True)
    assert done.stdout.startswith("planned "), done.stderr
    version = subprocess.run([python.parent / "foldpath", "--version"], env=environment, capture_output=True, text=True)
    assert version.stdout.startswith("foldpath ")


@pytest.fixture(scope="module")
def given() -> list[dict]:
    return designs(500)


@pytest.fixture(scope="module")
def expected(given: list[dict], tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    lines = by_command(tmp_path_factory.mktemp("batch"), given)
    assert len(lines) == 500
    return lines


def test_submitit_gives_the_same_bytes(given: list[dict], expected: list[str], tmp_path: Path) -> None:
    submitit = pytest.importorskip("submitit")
    executor = submitit.AutoExecutor(folder=tmp_path, cluster="local")
    executor.update_parameters(timeout_min=5)
    jobs = executor.map_array(plan_chunk, chunks(given, 250))
    assert [line for job in jobs for line in job.result()] == expected


def test_ray_gives_the_same_bytes(
    given: list[dict], expected: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "0")
    ray = pytest.importorskip("ray")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    try:
        work = ray.remote(plan_chunk)
        lines = ray.get([work.remote(chunk) for chunk in chunks(given, 100)])
    finally:
        ray.shutdown()
    assert [line for chunk in lines for line in chunk] == expected


def test_dask_gives_the_same_bytes(given: list[dict], expected: list[str]) -> None:
    bag = pytest.importorskip("dask.bag")
    work = bag.from_sequence(given, partition_size=100).map_partitions(plan_chunk)
    assert list(work.compute(scheduler="processes", num_workers=2)) == expected


def test_results_are_looked_up_in_parquet(expected: list[str], tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    page = (HERE.parent / "docs" / "batch.md").read_text()
    (program,) = [code for code in page.split("```python\n") if "sys.argv" in code]
    parts = tmp_path / "results"
    parts.mkdir()
    for shard in range(3):
        lines = tmp_path / f"{shard}.jsonl"
        lines.write_text("\n".join(expected[shard::3]) + "\n")
        code = program.split("```")[0]
        subprocess.run([sys.executable, "-c", code, lines, parts / f"{shard}.parquet"], check=True)
    told = {row["id"]: row for row in map(json.loads, expected)}
    (found,) = parquet.read_table(parts, filters=[("id", "=", "design-0123")]).to_pylist()
    assert found["knots"] == told["design-0123"]["knots"]
    table = parquet.read_table(parts, columns=["id"], filters=[("outcome", "=", "error")])
    assert sorted(table["id"].to_pylist()) == sorted(name for name, row in told.items() if "error" in row)
    wide = parquet.read_table(parts, columns=["id"], filters=[("min_clearance", ">", 0.1)])
    assert 0 < wide.num_rows < 500
    assert wide.num_rows == sum((row.get("min_clearance") or 0) > 0.1 for row in told.values())
