"""Bags from an object store and tables to it, by fsspec against a local server."""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("s3fs")
pytest.importorskip("moto")
pytest.importorskip("distributed")
pytest.importorskip("h3")

import fsspec

from friction_fleet.__main__ import main
from friction_fleet.dataset import BOUNDS, Dataset
from friction_fleet.settings import Settings
from friction_fleet.task import Task, process

PATIENCE = 120.0


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Start a server; name it to this process and to its workers."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "moto.server", "-H", "127.0.0.1", "-p", str(port)]
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    begun = time.monotonic()
    while True:
        assert time.monotonic() - begun < PATIENCE
        try:
            socket.create_connection(("127.0.0.1", port), 1.0).close()
            break
        except OSError:
            time.sleep(0.1)
    url = f"http://127.0.0.1:{port}"
    settings = {"AWS_ACCESS_KEY_ID": "test", "AWS_SECRET_ACCESS_KEY": "test", "AWS_DEFAULT_REGION": "us-east-1"}
    for name, value in {**settings, "AWS_ENDPOINT_URL": url}.items():
        monkeypatch.setenv(name, value)
    yield url
    child.kill()
    child.wait()


def test_bags_and_tables_may_be_in_an_object_store(server: str, bags: Path, tmp_path: Path) -> None:
    store = fsspec.filesystem("s3", skip_instance_cache=True)
    store.mkdir("fleet")
    for name in ("car000_drive000", "noise"):
        store.put(str(bags / name), f"fleet/bags/{name}", recursive=True)
    command = ["process", "s3://fleet/bags/*", "--out", "s3://fleet/tables", "--workers", "1"]
    assert main(command) == 1  # one is broken
    dataset = Dataset("s3://fleet/tables")
    assert [row["status"] for row in dataset.bags()] == ["ok", "error"]
    local = Dataset(str(tmp_path))
    process(Task(f"file://{bags}/car000_drive000", "", str(tmp_path), Settings(), Settings().digest()))
    assert dataset.table(BOUNDS).to_pylist() == local.table(BOUNDS).to_pylist()
    assert dataset.table(BOUNDS).num_rows > 0
    assert main(command) == 0  # nothing is left to do
    assert dataset.compact() == 0
