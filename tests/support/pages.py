"""The commands of the documentation, as a reader copies them.

A comment above a block says how it is run, which no reader of the page sees: `<!-- run with: nav2 -->` names the
gateway, without one it is that with simulated robots; `<!-- not run: needs Docker -->` says why it is not.
"""

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
# With a group each: the comment's kind and text, the language, the content.
BLOCK = re.compile(
    r"^(?:<!-- (not run|run with): ([^\n]+) -->\n)?```(bash|console|python|sh)\n(.*?)^```$", re.MULTILINE | re.DOTALL
)


@dataclass(frozen=True)
class Block:
    """Commands that are run one after the other.

    Attributes:
        page: The file, from the root of the repository.
        line: The number of its first line.
        commands: What is typed; empty if the block shows output alone.
        python: Whether they are Python rather than commands of a shell.
        gateway: The kind of gateway that they are for.
        reason: Why they are not run; empty if they are.
    """

    page: str
    line: int
    commands: str
    python: bool
    gateway: str
    reason: str

    @property
    def place(self) -> str:
        """Where it is, for messages."""
        return f"{self.page}:{self.line}"


def _is_complete(command: str) -> bool:
    """Whether each quotation is closed."""
    try:
        shlex.split(command, comments=True)
    except ValueError:
        return False
    return True


def typed(content: str) -> str:
    """What is typed in a terminal session: what follows `$ `, with the next lines while a quotation is open."""
    commands: list[str] = []
    for line in content.splitlines():
        if commands and not _is_complete(commands[-1]):
            commands[-1] += f"\n{line}"
        elif line.startswith("$ "):
            commands.append(line.removeprefix("$ "))
    return "\n".join(commands)


def blocks(page: Path) -> list[Block]:
    """Return the blocks of a page that hold commands, in order."""
    text = page.read_text()
    found = []
    for match in BLOCK.finditer(text):
        kind, value, language, content = match.groups("")
        found.append(
            Block(
                page=str(page.relative_to(ROOT)),
                line=text.count("\n", 0, match.start(3)) + 1,
                commands=typed(content) if language == "console" else content,
                python=language == "python",
                gateway=value if kind == "run with" else "simulated",
                reason=value if kind == "not run" else "",
            )
        )
    return [block for block in found if block.commands]
