"""What a first visit costs: bytes that are transferred, and how far the page's parts move while it loads."""

from dataclasses import dataclass

from playwright.sync_api import Browser, expect

# As https://web.dev/articles/cls defines a shift's score; `moved` says what moved, and from where to where.
WATCH = """
    window.shifts = [];
    const nameOf = (node) => {
        const element = node?.nodeType === 1 ? node : node?.parentElement;
        if (!element) return "gone";
        return `<${element.localName} class="${element.className}"> ${element.innerText?.slice(0, 80)}`;
    };
    const words = ({x, y, width, height}) => `${width}x${height} at ${x},${y}`;
    new PerformanceObserver((list) => {
        for (const {value, hadRecentInput, sources, startTime} of list.getEntries()) {
            if (hadRecentInput) continue;
            const moved = sources.map(({node, previousRect, currentRect}) =>
                `${nameOf(node)}: ${words(previousRect)} -> ${words(currentRect)}`);
            window.shifts.push({value, ms: Math.round(startTime), moved});
        }
    }).observe({type: "layout-shift", buffered: true});
"""


@dataclass(frozen=True)
class FirstVisit:
    """A first visit, with nothing in the browser's cache.

    Attributes:
        transferred: Bytes of all responses with their headers, as they were sent. Streams do not count.
        scripts: Bytes of the scripts among them.
        shift: Sum of the layout shifts.
        moved: The score and the time of each shift, and what moved from where to where.
    """

    transferred: int
    scripts: int
    shift: float
    moved: list[dict[str, object]]


def first_visit(browser: Browser, url: str, width: int = 1440, height: int = 1000) -> FirstVisit:
    """Open the overview of one simulated robot in a fresh profile, and wait until all that it shows has arrived."""
    with browser.new_context(viewport={"width": width, "height": height}, reduced_motion="reduce") as context:
        page = context.new_page()
        page.add_init_script(WATCH)
        devtools = context.new_cdp_session(page)
        kinds: dict[str, str] = {}
        sizes: dict[str, int] = {}
        devtools.on("Network.responseReceived", lambda event: kinds.update({event["requestId"]: event["type"]}))
        devtools.on(
            "Network.loadingFinished", lambda event: sizes.update({event["requestId"]: int(event["encodedDataLength"])})
        )
        devtools.send("Network.enable")
        page.goto(url)
        for title in ("Docking", "Map", "Battery", "Battery over time"):
            expect(page.get_by_role("region", name=title, exact=True)).to_be_visible()
        expect(page.locator("main .mantine-Skeleton-root:visible")).to_have_count(0)
        expect(page.locator("main canvas").first).to_be_visible()
        page.wait_for_load_state("networkidle")
        shifts = page.evaluate("() => window.shifts")
    scripts = sum(size for request, size in sizes.items() if kinds.get(request) == "Script")
    return FirstVisit(sum(sizes.values()), scripts, sum(shift["value"] for shift in shifts), shifts)
