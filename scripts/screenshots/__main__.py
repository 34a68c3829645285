"""Take pictures of every page of the dashboard, in both colour schemes and three widths, with simulated robots.

`make screenshots` renews those in docs/images. `make compare-screenshots BASE=main` shows each page of this tree and of
the revision BASE with the same data at the same moment, and marks what differs in test-results/screenshots.
"""

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, BrowserContext, sync_playwright
from scripts.screenshots.camera import Camera
from scripts.screenshots.comparison import compare
from scripts.screenshots.film import film_fleet
from scripts.screenshots.recording import Recording
from scripts.screenshots.scenes import (
    FLEET,
    FLEET_PAGES,
    NEAR,
    fleet_of_up,
    live_a_day,
    one_robot,
    several_robots,
    simulated,
    still_pages,
)
from tests.browser.conftest import ARGUMENTS, CHROMIUM, MISSING
from tests.support.domain import ros_domain
from tests.support.gateway import RunningGateway

ROOT = Path(__file__).resolve().parents[2]
DIST = Path("frontend/dist")
TOLERANCE = 0.001  # of the pixels of a picture
STREAM_S = 1.5  # of each page's streams


@contextmanager
def new_context(browser: Browser) -> Iterator[BrowserContext]:
    """A browser's context in which nothing moves by itself."""
    context = browser.new_context(locale="en-GB", reduced_motion="reduce")
    yield context
    context.close()


def renew_documents(browser: Browser, folder: Path, seconds: float) -> None:
    """Take every page, and those in docs/images."""
    images = ROOT / "docs/images"
    with ros_domain() as domain, simulated(domain, NEAR) as gateway, new_context(browser) as context:
        one_robot(Camera(context.new_page(), gateway.url, folder, images), gateway, domain, seconds)
    with ros_domain() as domain, simulated(domain, *FLEET) as gateway, new_context(browser) as context:
        several_robots(Camera(context.new_page(), gateway.url, folder, images), gateway)


def renew_film(browser: Browser, folder: Path) -> None:
    """Make the moving picture in the README."""
    with ros_domain() as domain, fleet_of_up(domain) as gateway:
        context = browser.new_context(locale="en-GB")
        film_fleet(
            Camera(context.new_page(), gateway.url, folder), gateway, folder / "film", ROOT / "docs/images/tour.webp"
        )
        context.close()


@contextmanager
def built(revision: str) -> Iterator[Path]:
    """The dashboard of a revision, built."""
    with tempfile.TemporaryDirectory(prefix="dashboard-") as folder:
        tree = Path(folder) / "tree"
        subprocess.run(["git", "worktree", "add", "--quiet", "--detach", tree, revision], cwd=ROOT, check=True)
        try:
            subprocess.run([tree / "scripts/build-dashboard"], check=True)
            yield tree / DIST
        finally:
            subprocess.run(["git", "worktree", "remove", "--force", tree], cwd=ROOT, check=True)


def record(browser: Browser, gateway: RunningGateway, pages: dict[str, str], folder: Path) -> dict[str, Recording]:
    """Open each page once, and keep what it was answered."""
    recordings = {}
    for name, path in pages.items():
        sys.stdout.write(f"recording {name}\n")
        recordings[name] = Recording()
        with new_context(browser) as context:
            recordings[name].record(context)
            Camera(context.new_page(), gateway.url, folder).open(path).wait_for_timeout(STREAM_S * 1000)
    return recordings


def compare_with(browser: Browser, base: str, folder: Path, seconds: float) -> bool:
    """Take each page of two builds with the same data; return whether they are alike."""
    with ros_domain() as domain, simulated(domain, NEAR) as gateway, new_context(browser) as context:
        docked = live_a_day(gateway, domain, Camera(context.new_page(), gateway.url, folder).open("/"), seconds)
        pages = {"overview": "/", **still_pages(docked)}
        recordings = record(browser, gateway, pages, folder)
    with ros_domain() as domain, simulated(domain, *FLEET) as gateway:
        fleet = {"fleet": "/", **FLEET_PAGES, "wall": "/ui/wall"}
        recordings |= record(browser, gateway, fleet, folder)
        pages |= fleet
    with built(base) as dist:
        for name, recording in recordings.items():
            for build, files in {"before": dist, "after": ROOT / DIST}.items():
                with new_context(browser) as context:
                    recording.replay(context, files)
                    camera = Camera(context.new_page(), gateway.url, folder / build)
                    camera.open(pages[name]).evaluate("holdTime()")
                    camera.take(name)
    with new_context(browser) as context:
        differences = compare(context.new_page(), folder / "before", folder / "after", folder / "marked", TOLERANCE)
    for name, share in differences:
        sys.stdout.write(f"{folder / 'marked' / name}: {share:.2%} of the pixels differ\n")
    sys.stdout.write(f"{len(differences)} pictures differ from {base}\n")
    return not differences


def main() -> None:
    """Take them all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--film", action="store_true", help="make only the moving picture of the README")
    parser.add_argument("--compare", metavar="REVISION", help="compare with the dashboard of this revision instead")
    parser.add_argument("--folder", type=Path, default=ROOT / "test-results/screenshots", help="where they go")
    parser.add_argument("--seconds", type=float, default=None, help="of battery data in the plots (240, or 20)")
    arguments = parser.parse_args()
    if CHROMIUM is None:
        sys.exit(MISSING)
    with (
        sync_playwright() as playwright,
        playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS) as browser,
    ):
        if arguments.film:
            renew_film(browser, arguments.folder)
        elif arguments.compare is None:
            renew_documents(browser, arguments.folder, arguments.seconds or 240.0)
            renew_film(browser, arguments.folder)
        elif not compare_with(browser, arguments.compare, arguments.folder, arguments.seconds or 20.0):
            sys.exit(1)


if __name__ == "__main__":
    main()
