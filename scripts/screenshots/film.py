"""Films the moving picture in the README: three robots dock, are stopped and released, and a goal is replayed."""

import json
import re
import subprocess
import sys
import time
from pathlib import Path

from playwright.sync_api import Locator, Page, expect
from scripts.screenshots.camera import Camera
from scripts.screenshots.scenes import robots_of
from tests.browser.conftest import PATIENCE_MS
from tests.support.gateway import RunningGateway
from tests.support.waiting import wait_until

WIDTH, HEIGHT = 1200, 750
# Seconds between two frames, and how much faster than that they are shown.
PERIOD_S, SPEED = 0.3, 2.0
# Seconds that a viewer needs to see what is going to be pressed, and to read what a scene is about.
LOOK_S, READ_S = 0.8, 1.4
# What makes the picture of the frames: Pillow, in an environment of the documentation.
PYTHON = Path(".site/environment/bin/python")
STOPPED = re.compile("^All .*stopped")
# A pointer, which a browser without a window does not draw, and a line that says what happens.
# Notices are left out: they would cover robots.
OVERLAY = """([text, x, y]) => {
  const part = (id, shown, style) => {
    const found = document.getElementById(id) ?? document.body.appendChild(document.createElement("div"));
    found.id = id;
    found.style.cssText = `position: fixed; z-index: 9999; pointer-events: none; ${style}`;
    found.hidden = !shown;
    return found;
  };
  part("film-text", text, `
    left: 20px; bottom: 20px; padding: 10px 22px; border-radius: 8px;
    background: #111d; color: #fff; font: 600 22px sans-serif; white-space: nowrap;
  `).textContent = text;
  for (const notices of document.querySelectorAll(".mantine-Notifications-root")) notices.style.display = "none";
  part("film-pointer", x >= 0, `
    left: ${x - 16}px; top: ${y - 16}px; width: 26px; height: 26px; border-radius: 50%;
    background: #f5a52488; border: 3px solid #f5a524;
  `);
}"""


class Film:
    """Frames of a page, each with the time that it is shown.

    Args:
        page: The page.
        folder: Where the frames go.
    """

    def __init__(self, page: Page, folder: Path) -> None:
        self._page, self._folder = page, folder
        self._text = ""
        self._durations: list[int] = []
        folder.mkdir(parents=True, exist_ok=True)
        for frame in folder.glob("*.png"):
            frame.unlink()
        page.set_viewport_size({"width": WIDTH, "height": HEIGHT})

    def say(self, text: str) -> None:
        """Show a line below the page from now on, and give the viewer time to read it."""
        self._text = text
        self._shoot(READ_S)

    def press(self, what: Locator) -> None:
        """Point at something, and press it."""
        what.scroll_into_view_if_needed()
        box = what.bounding_box()
        assert box is not None
        self._shoot(LOOK_S, (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2))
        what.click()

    def run(self, seconds: float) -> None:
        """Film for a while."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            began = time.monotonic()
            self._shoot(PERIOD_S / SPEED)
            self._page.wait_for_timeout(1000 * max(0.0, began + PERIOD_S - time.monotonic()))

    def develop(self, target: Path) -> None:
        """Make the picture."""
        (self._folder / "durations.json").write_text(json.dumps(self._durations))
        subprocess.run([PYTHON, "scripts/screenshots/develop.py", self._folder, target], check=True)
        sys.stdout.write(f"{target}: {target.stat().st_size // 1000} kB\n")

    def _shoot(self, seconds: float, pointer: tuple[float, float] = (-1, -1)) -> None:
        self._page.evaluate(OVERLAY, [self._text, *pointer])
        self._page.screenshot(path=self._folder / f"{len(self._durations):04}.png", caret="hide")
        self._durations.append(round(1000 * seconds))


def film_fleet(camera: Camera, gateway: RunningGateway, folder: Path, target: Path) -> None:
    """Film a fleet of three."""
    page = camera.open("/")
    film = Film(page, folder)
    film.say("Three simulated robots, ROS 2 actions, one browser")
    film.press(page.get_by_role("checkbox", name="Select all"))
    film.press(page.get_by_role("button", name="Dock", exact=True))
    confirm(film, page)
    film.run(2.0)
    page = camera.open("/ui/map")
    film.say("They drive to their docks")
    film.run(4.0)
    film.press(page.get_by_role("button", name="Stop", exact=True).first)
    expect(page.get_by_role("status").filter(has_text=STOPPED).first).to_be_visible(timeout=PATIENCE_MS)
    film.say("Stop: all stand still, and no goal starts")
    film.run(2.0)
    film.press(page.get_by_role("button", name="Release").first)
    film.press(page.get_by_role("dialog").get_by_role("button", name="Release"))
    goals = [dock(gateway, robot) for robot in sorted(robots_of(gateway))]
    film.say("Released: on to the docks")
    for _ in range(30):
        film.run(1.0)
        if all(gateway.http.get(f"/goals/{goal}").json()["finished_at"] for goal in goals):
            break
    film.say("Docked, and charging")
    wait_until(lambda: gateway.http.get(f"/goals/{goals[0]}").json()["finished_at"], "the end of the goal")
    page = camera.open(f"/ui/goals/{goals[0]}")
    # Below the header: the replay, and what it moves.
    page.get_by_role("heading", name="Replay").evaluate("e => scrollBy(0, e.getBoundingClientRect().top - 140)")
    film.say("Each goal can be replayed")
    film.press(page.get_by_role("button", name="Play", exact=True))
    film.run(6.0)
    film.develop(target)


def dock(gateway: RunningGateway, robot: str) -> str:
    """Send a robot to its dock as soon as its last goal has ended; return the goal's id."""
    wait_until(lambda: gateway.http.post("/dock", params={"robot": robot}).status_code == 202, f"a goal of {robot}")
    goal: str = gateway.http.get("/goals", params={"robot": robot, "limit": 1}).json()["goals"][0]["goal_id"]
    return goal


def confirm(film: Film, page: Page) -> None:
    """Press what a dialog asks to, if one has come."""
    page.wait_for_timeout(500)
    dialog = page.get_by_role("dialog")
    if dialog.count():
        film.press(dialog.get_by_role("button", name="Dock").first)
