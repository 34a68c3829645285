"""The extension of another distribution, examples/extension, installed from its wheel."""

import shutil
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[2]
UV = shutil.which("uv") or str(ROOT / ".tools/uv/bin/uv")


def install_example(folder: Path) -> Path:
    """Build the wheel, and install it in a folder; return the folder for PYTHONPATH."""
    build = (UV, "build", "--wheel", "--build-constraints", "build-requirements.lock", "--out-dir", str(folder))
    subprocess.run([*build, "examples/extension"], cwd=ROOT, check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    install = (UV, "pip", "install", "--target", str(folder / "site"), "--no-deps", str(wheel))
    subprocess.run(install, cwd=ROOT, check=True, capture_output=True)
    return folder / "site"
