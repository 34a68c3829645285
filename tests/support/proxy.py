"""A plain TCP reverse proxy: hands each connection to the first backend that takes it, in turn."""

import contextlib
import itertools
import socket
import threading
from collections.abc import Iterator

Address = tuple[str, int]


class Proxy:
    """Listens on a free port. `backends` may change while it runs."""

    def __init__(self, backends: list[Address]) -> None:
        self.backends = backends
        self._turn = itertools.count()
        self._clients: list[socket.socket] = []
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self._listener.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                client, _ = self._listener.accept()
                self._clients.append(client)
                threading.Thread(target=self._serve, args=(client,), daemon=True).start()

    def _serve(self, client: socket.socket) -> None:
        first = next(self._turn)
        for step in range(len(self.backends)):
            try:
                backend = socket.create_connection(self.backends[(first + step) % len(self.backends)], timeout=5)
            except OSError:
                continue
            backend.settimeout(None)
            threading.Thread(target=_pump, args=(backend, client), daemon=True).start()
            _pump(client, backend)
            return
        client.close()

    def cut(self) -> None:
        """Break all connections."""
        while self._clients:
            with contextlib.suppress(OSError):  # it has ended
                self._clients.pop().shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        self._listener.close()


def _pump(source: socket.socket, sink: socket.socket) -> None:
    with contextlib.suppress(OSError):
        while data := source.recv(65536):
            sink.sendall(data)
    for end in (source, sink):
        with contextlib.suppress(OSError):
            end.shutdown(socket.SHUT_RDWR)
        end.close()


@contextlib.contextmanager
def proxy(*urls: str) -> Iterator[Proxy]:
    """A proxy in front of gateways, by their addresses."""
    backends = [(host, int(port)) for host, port in (url.removeprefix("http://").split(":") for url in urls)]
    running = Proxy(backends)
    try:
        yield running
    finally:
        running.close()
