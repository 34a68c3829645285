"""`make release` refuses a commit whose version, tag and changelog do not agree."""

import shutil
import subprocess
from pathlib import Path

import pytest

CHECK = Path(__file__).parents[2] / "scripts/check-release"


class Clone:
    """A repository with what the check reads."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.write("scripts/check-release", CHECK.read_text())
        self.write("backend/dock_gateway/__init__.py", '__version__ = "1.2.0"\n')
        self.write("frontend/client/package.json", '{\n  "version": "1.2.0",\n}\n')
        self.write("CHANGELOG.md", "## [Unreleased]\n\n## [1.2.0] - 2026-01-31\n")
        self._git("init", "--quiet")
        self.commit()
        self.tag("v1.2.0")

    def write(self, name: str, text: str) -> None:
        path = self._folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def commit(self) -> None:
        self._git("add", "--all")
        self._git("commit", "--quiet", "--message", "x")

    def tag(self, name: str) -> None:
        self._git("tag", name)

    def _git(self, *arguments: str) -> None:
        who = ("-c", "user.name=x", "-c", "user.email=x@example.org", "-c", "commit.gpgsign=false")
        subprocess.run(["git", *who, *arguments], cwd=self._folder, check=True)

    def check(self) -> str:
        """What the check prints on either stream, in one line."""
        command = ["bash", self._folder / "scripts/check-release"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        output = (done.stdout + done.stderr).strip()
        assert done.returncode == (1 if output.startswith("No release: ") else 0)
        assert len(output.splitlines()) == 1
        return output


@pytest.fixture
def clone(tmp_path: Path) -> Clone:
    if shutil.which("git") is None:
        pytest.skip("git is not installed")
    return Clone(tmp_path)


def test_version_tag_and_changelog_agree(clone: Clone) -> None:
    assert clone.check() == "1.2.0"


def test_what_is_not_committed_is_no_release(clone: Clone) -> None:
    clone.write("more.py", "")
    assert "run git status" in clone.check()


def test_a_new_version_needs_a_heading_and_a_tag(clone: Clone) -> None:
    clone.write("backend/dock_gateway/__init__.py", '__version__ = "1.3.0"\n')
    clone.commit()
    assert "frontend/client/package.json has another version" in clone.check()
    clone.write("frontend/client/package.json", '{\n  "version": "1.3.0",\n}\n')
    clone.commit()
    assert 'CHANGELOG.md has no heading "## [1.3.0] - ' in clone.check()
    clone.write("CHANGELOG.md", "## [1.3.0] - 2026-02-28\n")
    clone.commit()
    assert "git tag --annotate v1.3.0" in clone.check()
    clone.tag("v1.3.0")
    assert clone.check() == "1.3.0"
