"""Gateways that are killed and started again."""

import contextlib
import random
import re
import signal
from collections import Counter
from datetime import datetime
from typing import Self

from tests.support.gateway import RunningGateway, running_gateway
from tests.support.processes import Process, free_port
from tests.support.waiting import wait_until

UUID = r"[0-9a-f]{8}-[0-9a-f-]{27}"
HISTORY = re.compile(r"\[(?P<time>[-\d]+ [:,\d]+)\].*the history database (?:answers|(?P<away>does not answer))")
GIVES_UP = 5.0  # seconds: more than a gateway waits for the database before it says so


class Fleet:
    """Gateways that share a database, each on a port of its own, killed and started again; see `running_gateway`."""

    def __init__(self, domain: int, count: int, *prefix: str, **settings: str) -> None:
        self._domain = domain
        self._prefix = prefix
        self._settings = settings
        self._ports = [free_port() for _ in range(count)]
        self._stacks = [contextlib.ExitStack() for _ in range(count)]
        self.running: dict[int, RunningGateway] = {}
        self.processes: list[Process] = []

    def __enter__(self) -> Self:
        for number in range(len(self._ports)):
            self.start(number)
        return self

    def __exit__(self, *error: object) -> None:
        for stack in self._stacks:
            stack.close()

    def url(self) -> str:
        """A gateway that runs, as far as is known."""
        ports = [self._ports[number] for number in list(self.running)] or self._ports
        return f"http://127.0.0.1:{random.choice(ports)}"

    def start(self, number: int) -> None:
        settings = {**self._settings, "port": str(self._ports[number])}
        settings["spool_path"] += f"-{number}"
        gateway = self._stacks[number].enter_context(running_gateway(self._domain, *self._prefix, **settings))
        self.running[number] = gateway
        self.processes.append(gateway.process)

    def kill(self, number: int) -> None:
        gateway = self.running.pop(number)
        gateway.process.send_signal(signal.SIGKILL)
        gateway.process.wait()
        self._stacks[number].close()

    def end(self, number: int) -> None:
        """End a gateway as an operator does; it writes what it has."""
        self.running.pop(number)
        self._stacks[number].close()

    def warnings(self) -> Counter[str]:
        """What the gateways warned of, whichever goal it was about."""
        lines = "\n".join(process.output for process in self.processes).splitlines()
        warnings = (line.partition("]: ")[2] for line in lines if line.startswith(("[WARNING]", "[ERROR]")))
        return Counter(re.sub(UUID, "…", text)[:120] for text in warnings)

    def told_before_stored(self) -> set[str]:
        """Goals of which a gateway says that the database, or the result, took longer than what is promised."""
        lines = "\n".join(process.output for process in self.processes).splitlines()
        return {goal_id for line in lines if "before it" in line for goal_id in re.findall(UUID, line)}

    def database_was_slow(self, at: float) -> bool:
        """Whether the database did not answer a gateway at a time, in seconds since 1970, as that says."""
        for process in self.processes:
            began = None
            for line in process.output.splitlines():
                if (found := HISTORY.search(line)) is None:
                    continue
                when = datetime.strptime(found["time"], "%Y-%m-%d %H:%M:%S,%f").astimezone().timestamp()
                if found["away"] and began is None:
                    began = when - GIVES_UP
                elif not found["away"] and began is not None:
                    if began <= at <= when:
                        return True
                    began = None
            if began is not None and began <= at:
                return True
        return False

    def any(self) -> RunningGateway:
        return next(iter(self.running.values()))


def wait_for_action(fleet: Fleet) -> None:
    """Wait until each gateway has found the action."""
    for gateway in fleet.running.values():
        wait_until(lambda http=gateway.http: http.get("/actions/fibonacci").status_code == 200, "the action")
