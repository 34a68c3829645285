"""Files of the dashboard, compressed at build, in the encoding that the client accepts."""

import hashlib
import os
import re
from collections.abc import Iterable
from functools import lru_cache
from mimetypes import guess_type
from pathlib import Path

from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.responses import FileResponse, Response
from starlette.staticfiles import NotModifiedResponse, StaticFiles
from starlette.types import Scope as ConnectionScope

# Best first. The build writes `index.html.br` next to `index.html`.
_SUFFIXES = {"br": ".br", "gzip": ".gz"}
_CODING = re.compile(r"\s*([a-z*]+)\s*(?:;\s*q=(0(?:\.\d{0,3})?|1(?:\.0{0,3})?)\s*)?", re.ASCII | re.IGNORECASE)


def choose_encoding(accept_encoding: str, available: Iterable[str]) -> str:
    """Choose a content coding by RFC 9110, section 12.5.3.

    Args:
        accept_encoding: The header; empty if the request has none. Unknown codings and invalid weights are ignored.
        available: The codings of the file except `identity`, best first.

    Returns:
        The coding with the highest weight, the first of equal ones; `identity` if none is accepted.
    """
    matches = filter(None, map(_CODING.fullmatch, accept_encoding.split(",")))
    weights = {match[1].lower(): float(match[2] or 1) for match in matches}
    best = max((*available, "identity"), key=lambda coding: weights.get(coding, weights.get("*", 0.0)))
    return best if weights.get(best, weights.get("*", 0.0)) else "identity"


def is_compressed(path: str) -> bool:
    """Whether a file is the compressed form of another, which has no address of its own."""
    return path.endswith(tuple(_SUFFIXES.values()))


class CompressedFiles(StaticFiles):
    """Serves a folder whose files may have a compressed form next to them."""

    def __init__(self, directory: Path, headers: dict[str, str]) -> None:
        super().__init__(directory=directory)
        self._headers = headers

    async def get_response(self, path: str, scope: ConnectionScope) -> Response:
        """Answer a request for a file of the folder."""
        if is_compressed(path):
            raise HTTPException(status_code=404)
        return await super().get_response(path, scope)

    def file_response(
        self,
        full_path: str | os.PathLike[str],
        stat_result: os.stat_result,
        scope: ConnectionScope,
        status_code: int = 200,
    ) -> Response:
        """Answer with the file in the best encoding, or that the client's copy is current."""
        request = Headers(scope=scope)
        forms = {coding: Path(f"{full_path}{suffix}") for coding, suffix in _SUFFIXES.items()}
        found = [coding for coding, form in forms.items() if form.is_file()]
        coding = choose_encoding(", ".join(request.getlist("accept-encoding")), found)
        path = forms.get(coding, Path(full_path))
        found_stat = path.stat()
        headers = {**self._headers, "Vary": "Accept-Encoding", "ETag": _tag(path, found_stat.st_mtime_ns)}
        if coding != "identity":
            headers["Content-Encoding"] = coding
        media_type = guess_type(full_path)[0] or "text/plain"
        response = FileResponse(path, status_code, headers, media_type=media_type, stat_result=found_stat)
        if not self.is_not_modified(response.headers, request):
            return response
        not_modified = NotModifiedResponse(response.headers)
        # A cache takes over these headers, too: without its own policy a page would get that of data.
        not_modified.headers.update(self._headers)
        return not_modified


@lru_cache(maxsize=256)
def _tag(path: Path, _modified_ns: int) -> str:
    """The ETag of a file's content. An installer may give files of two versions the same size and time."""
    return f'"{hashlib.sha256(path.read_bytes()).hexdigest()[:32]}"'
