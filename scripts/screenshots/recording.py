"""What a page asked the gateway, and the same answers for another build of the dashboard, at the same moment."""

import mimetypes
from collections import defaultdict
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from urllib.parse import parse_qsl, urlencode, urlsplit

from playwright.sync_api import BrowserContext, Route, WebSocketRoute

# Time in a replay passes slowly, and then hardly at all: nothing becomes stale while pictures are taken.
SLOW_TIME = """(() => {
  const real = performance.now.bind(performance);
  let [since, passed, speed] = [real(), 0, 0.25];
  performance.now = () => passed + (real() - since) * speed;
  globalThis.holdTime = () => { [since, passed, speed] = [real(), performance.now(), 0.01]; };
  Object.defineProperty(performance, "timeOrigin", { value: MOMENT });
})()"""


@dataclass
class Recording:
    """The answers and the streams of one page.

    Attributes:
        moment: What the browser takes for now, all the time.
        answers: By method and address, the first of each: status, content type and body.
        streams: By address: the frames since the page was opened.
    """

    moment: datetime = field(default_factory=lambda: datetime.now(UTC))
    answers: dict[tuple[str, str], tuple[int, str, bytes]] = field(default_factory=dict)
    streams: dict[str, list[str | bytes]] = field(default_factory=lambda: defaultdict(list))

    def record(self, context: BrowserContext) -> None:
        """Record what the pages of a context are answered; to be called before they are opened."""

        def pass_on(route: Route) -> None:
            if route.request.resource_type not in {"fetch", "xhr"}:
                return route.continue_()
            answer = route.fetch()
            key = (route.request.method, _address(route.request.url))
            self.answers.setdefault(key, (answer.status, answer.headers.get("content-type", ""), answer.body()))
            return route.fulfill(response=answer)

        def listen(socket: WebSocketRoute) -> None:
            frames = self.streams[_address(socket.url)] = []
            server = socket.connect_to_server()

            def hear(frame: str | bytes) -> None:
                frames.append(frame)
                socket.send(frame)

            server.on_message(hear)

        context.clock.set_fixed_time(self.moment)
        context.route("**/*", pass_on)
        context.route_web_socket("**/ws**", listen)
        context.route_web_socket("**/ws/**", listen)

    def replay(self, context: BrowserContext, dist: Path) -> None:
        """Answer the pages of a context as recorded, with the files of a build."""

        def answer(route: Route) -> None:
            path = urlsplit(route.request.url).path
            file = dist / path.lstrip("/")
            if route.request.is_navigation_request():
                route.fulfill(path=dist / "index.html")
            elif file.is_file():
                route.fulfill(path=file, content_type=mimetypes.guess_type(file.name)[0])
            elif known := self.answers.get((route.request.method, _address(route.request.url))):
                status, content_type, body = known
                route.fulfill(status=status, content_type=content_type, body=body)
            else:
                route.fulfill(status=404, content_type="application/problem+json", body=b'{"title":"not recorded"}')

        def tell(socket: WebSocketRoute) -> None:
            for frame in self.streams.get(_address(socket.url), ()):
                socket.send(frame)

        context.clock.set_fixed_time(self.moment)
        context.add_init_script(SLOW_TIME.replace("MOMENT", str(self.moment.timestamp() * 1000)))
        context.route("**/*", answer)
        context.route_web_socket("**/ws**", tell)
        context.route_web_socket("**/ws/**", tell)


def _address(url: str) -> str:
    """The path and the query, in one order, without times."""
    parts = urlsplit(url)
    query = sorted((name, value) for name, value in parse_qsl(parts.query) if name not in {"after", "since", "until"})
    return f"{parts.path}?{urlencode(query)}"
