"""Finds the programs of this installation."""

import shutil
import sys
from pathlib import Path

import click


def find_program(name: str) -> str:
    """Return the path of a program, of the same environment if that has it.

    Raises:
        click.ClickException: It is not installed.
    """
    installed = Path(sys.executable).parent / name
    found = str(installed) if installed.exists() else shutil.which(name)
    if found is None:
        raise click.ClickException(f"{name} is not installed")
    return found
