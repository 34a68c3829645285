"""A ROS domain that nothing else on this machine uses, for as long as it is held."""

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def ros_domain() -> Iterator[int]:
    """Reserve a ROS_DOMAIN_ID by a lock file, so that test runs side by side never meet."""
    folder = Path(tempfile.gettempdir()) / f"ros-domains-{os.getuid()}"
    folder.mkdir(exist_ok=True)
    for domain in range(20, 100):
        with (folder / str(domain)).open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield domain
            return
    raise RuntimeError("every ROS domain from 20 to 99 is in use")
