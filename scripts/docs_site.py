"""Gathers the pages of the documentation site in a folder, with those that are generated; `make docs` builds the site.

The pages keep their places below the root of the repository, so that their links hold. The files that they link to,
which are no pages, are shown on a page of their own, since the site is read without the repository.
"""

import json
import re
import shutil
import sys
from os.path import relpath
from pathlib import Path

from scripts.docs_modules import modules_page
from scripts.docs_openapi import anchor, operations_page, schemas_page

ROOT = Path(__file__).parents[1]
TOP_PAGES = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"]
FILES = Path("docs/files.md")
FILES_HEAD = "# Files of the repository\n\nFiles that other pages link to.\n"
# The search of a site that is read from files, without a web server.
SEARCH = Path("frontend/node_modules/iframe-worker/shim/index.js")
LANGUAGES = {".py": "python"}
LINK = re.compile(r"\[([^\]]*)\]\(([^)\s:#]+)(#[^)\s]*)?\)")


def title(page: Path) -> str:
    """The heading of a page."""
    return page.read_text().removeprefix("# ").partition("\n")[0]


def with_links(page: Path, linked: set[Path]) -> str:
    """A page as the site shows it, and in `linked` the files that it links to.

    Links to files that are no pages lead to the page of files. A link that is named after the file of a page is named
    after the page.
    """

    def replaced(match: re.Match[str]) -> str:
        text, link, heading = match.groups("")
        target = (ROOT / page.parent / link).resolve()
        if not target.exists():
            sys.exit(f"{page}: there is no file {link}")
        is_page = target.suffix == ".md" and (target.is_relative_to(ROOT / "docs") or target.parent == ROOT)
        if is_page and text.endswith(target.name):
            return f"[{title(target)}]({link}{heading})"
        if is_page or target.is_relative_to(ROOT / "docs"):
            return match[0]
        path = target.relative_to(ROOT)
        linked.add(path)
        return f"[{text}]({relpath(FILES, page.parent)}#{anchor(str(path))})"

    return LINK.sub(replaced, (ROOT / page).read_text())


def section(path: Path) -> str:
    """A heading, and the text of a file or the names of the files in a folder."""
    if (ROOT / path).is_dir():
        files = sorted(file.relative_to(ROOT) for file in (ROOT / path).rglob("*.*") if file.suffix != ".pyc")
        text = "\n".join(f"- `{file}`" for file in files)
    else:
        text = f"````{LANGUAGES.get(path.suffix, 'text')}\n{(ROOT / path).read_text()}````"
    return f"\n## `{path}` {{ #{anchor(str(path))} }}\n\n{text}\n"


def gather(target: Path) -> None:
    """Write all pages to a folder, which is emptied first."""
    shutil.rmtree(target, ignore_errors=True)
    shutil.copytree(ROOT / "docs", target / "docs")
    shutil.copy(ROOT / SEARCH, target / "docs/assets/iframe-worker.js")
    linked: set[Path] = set()
    for page in [*map(Path, TOP_PAGES), *(path.relative_to(ROOT) for path in (ROOT / "docs").rglob("*.md"))]:
        (target / page).write_text(with_links(page, linked))
    (target / FILES).write_text(FILES_HEAD + "".join(map(section, sorted(linked))))
    document = json.loads((ROOT / "frontend/openapi.json").read_text())
    (target / "docs/operations.md").write_text(operations_page(document))
    (target / "docs/schemas.md").write_text(schemas_page(document))
    (target / "docs/modules.md").write_text(modules_page(ROOT / "backend"))


if __name__ == "__main__":
    gather(Path(sys.argv[1]))
