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
    first = os.getpid() % 80  # runs that follow one another take different ones
    for domain in (20 + (first + step) % 80 for step in range(80)):
        with (folder / str(domain)).open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            _remove_shared_memory(domain)
            yield domain
            return
    raise RuntimeError("every ROS domain from 20 to 99 is in use")


def _remove_shared_memory(domain: int) -> None:
    """Processes killed on this domain left their Fast DDS ports behind, which would disturb new ones for seconds."""
    first = 7400 + 250 * domain  # the domain's ports, as the DDSI-RTPS standard numbers them
    for file in Path("/dev/shm").glob("*fastrtps_port*"):
        number = "".join(character for character in file.name.partition("_port")[2] if character.isdecimal())
        if number and first <= int(number) < first + 250:
            file.unlink(missing_ok=True)
