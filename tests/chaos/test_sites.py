"""Sites, hub and broker that are killed in turn, with bad connections and clocks: no goal is missing or repeated.

The broker is a real NATS server. The sites are simulated, behind the real connection, tunnel and verification; so what
they have stored is known, and their clocks can be an hour off.
"""

import os
import random
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import httpx2
import pytest

from tests.chaos.load import FINAL
from tests.chaos.report import report
from tests.chaos.sites import Commander, HubReader, Sites, Stopper, commanders
from tests.support.installed import needs
from tests.support.probe import memory, quantile
from tests.support.site_floods import AT_HUB, AT_SITE, flooding
from tests.support.waiting import wait_until

pytestmark = [needs("sites"), pytest.mark.timeout(7200)]

# Rounds of kills and cuts, and about how long connections are cut or silent.
ROUNDS = int(os.environ.get("CHAOS_SITE_ROUNDS", "1"))
SECONDS = float(os.environ.get("CHAOS_SITE_SECONDS", "0.5"))
# Seconds of a flood; the promise to a stop within it, and after it. A machine that other tests share is slower.
FLOOD_SECONDS = float(os.environ.get("CHAOS_SECONDS", "1"))
STOPPED_WITHIN = 1.0 if FLOOD_SECONDS >= 5 else 3.0


def kill(sites: Sites, name: str) -> None:
    sites.kill(name)
    time.sleep(random.uniform(0.0, 0.5))
    sites.start(name)


def kill_broker(sites: Sites) -> None:
    sites.broker.kill()
    time.sleep(random.uniform(0.0, 1.0) * SECONDS)
    sites.broker.start()


def cut(sites: Sites, name: str) -> None:
    with sites.links[name].cut():
        time.sleep(random.uniform(0.5, 1.5) * SECONDS)


def silence(sites: Sites, name: str) -> None:
    with sites.links[name].silent():
        time.sleep(random.uniform(0.5, 1.5) * SECONDS)


def stop_while_away(sites: Sites, name: str) -> Stopper:
    """Stop a site that nobody reaches at the moment."""
    with sites.links[name].cut():
        stopper = Stopper(sites.url, name)
        stopper.start()
        time.sleep(0.5)
        wait_until(lambda: stopper.code, "the answer to a stop")
    return stopper


def check_stop(sites: Sites, stopper: Stopper) -> str:
    """What became of a stop: it has to be in force at the site, whatever the hub had answered. Release it."""
    try:
        wait_until(lambda: sites.latched(stopper.site), f"the stop of {stopper.site}", timeout=60)
    except AssertionError:
        return f"{stopper.code}, then forgotten"
    wait_until(lambda: not release(sites, stopper.site), "its release", timeout=60)
    return "200" if stopper.code == "200" else f"{stopper.code}, then carried out"


def release(sites: Sites, site: str) -> bool:
    """Ask the hub to release a stop; return whether it still holds."""
    try:
        httpx2.delete(f"{sites.url}/stop?robot=/{site}", timeout=20, trust_env=False)
    except httpx2.HTTPError:
        return True
    return sites.latched(site)


def compare(sites: Sites, reader: HubReader, workers: list[Commander], kills: int, stops: list[str]) -> dict[str, Any]:
    """What the sites have, and what the hub and its reader have of it."""
    at_sites = {goal_id: (site, goal) for site in sites.names for goal_id, goal in sites.goals(site).items()}
    missing, wrong = [], []
    with httpx2.Client(base_url=sites.url, timeout=30, trust_env=False) as http:
        for goal_id, (site, goal) in at_sites.items():
            answer = http.get(f"/goals/{goal_id}")
            if answer.status_code != 200:
                missing.append(goal_id)
                continue
            found = answer.json()
            wanted = (f"/{site}{goal['action_name']}", goal["status"], goal["result"])
            if (found["action_name"], found["status"], found["result"]) != wanted:
                wrong.append((wanted, found))
    executed = sum((sites.executed(site) for site in sites.names), Counter[int]())
    accepted = {number for worker in workers for number in worker.accepted}
    results, statuses = reader.ends("result"), reader.ends("status")
    ids = Counter(event["id"] for event in reader.events)
    return {
        "kills and cuts": kills,
        "goals at the sites": len(at_sites),
        "goals missing at the hub": len(missing),
        "goals that are different at the hub": len(wrong),
        "commands accepted": len(accepted),
        "commands accepted and not carried out": len(accepted - executed.keys()),
        "commands carried out twice": sum(count > 1 for count in executed.values()),
        "ends reported twice": sum(results[goal_id] > 1 or statuses[goal_id] > 1 for goal_id in at_sites),
        "ends not reported": sum(not results[goal_id] or not statuses[goal_id] for goal_id in at_sites),
        "event ids read twice": sum(count > 1 for count in ids.values()),
        "events older than `after`": len(reader.older),
        "gaps": reader.notices["gap"],
        "stops": dict(Counter(stops)),
        "stops forgotten": sum("forgotten" in stop for stop in stops),
        "messages repeated, reordered": tuple(
            sum(getattr(link, what) for link in sites.links.values()) for what in ("repeated", "overtaken")
        ),
        "answers": dict(sum((worker.answers for worker in workers), Counter[str]())),
    }


def test_sites_hub_and_broker_that_are_killed_in_turn(tmp_path: Path) -> None:
    stops: list[str] = []
    kills = 0
    with Sites(tmp_path) as sites, ExitStack() as stack:
        sites.wait_for_all()
        reader = HubReader(lambda: sites.url)
        reader.start()
        wait_until(lambda: reader.notices["snapshot"], "the reader")  # what is in its snapshot is not told as an event
        workers = stack.enter_context(commanders(sites, each=1 if ROUNDS == 1 else 2))
        wait_until(lambda: reader.events, "an event to resume after")
        for _ in range(ROUNDS):
            site, other, third = random.sample(sites.names, 3)
            kill(sites, site)  # a killed site is welcome again after 10 s
            stopper = stop_while_away(sites, other)
            kill(sites, "hub")
            stops.append(check_stop(sites, stopper))
            kill_broker(sites)
            cut(sites, third)
            silence(sites, "hub")
            cut(sites, "hub")
            kills += 7
        for worker in workers:
            worker.finish(120)
        sites.wait_for_all()
        ended = {
            goal_id for name in sites.names for goal_id, goal in sites.goals(name).items() if goal["status"] in FINAL
        }
        with suppress(AssertionError):  # `compare` says what is missing
            wait_until(lambda: ended <= reader.ends("result").keys(), "the ends of all goals", timeout=60)
        reader.finish()
        figures = compare(sites, reader, workers, kills, stops)
    report("Sites, a hub and a NATS server, killed and cut off in turn", figures)
    assert figures["goals at the sites"] > kills
    zero = ("missing", "different", "not carried out", "twice", "not told", "older", "gaps", "forgotten")
    assert {name: value for name, value in figures.items() if value and any(word in name for word in zero)} == {}


@pytest.fixture(scope="module")
def flooded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Sites]:
    """A hub with the sites berlin and oslo, with perfect connections."""
    with Sites(tmp_path_factory.mktemp("sites"), {"berlin": 0.0, "oslo": 0.0}, duplicated=0, reordered=0) as sites:
        sites.wait_for_all()
        yield sites


def stop_once(sites: Sites, site: str) -> float:
    """Seconds until a site has confirmed a stop."""
    began = time.monotonic()
    answer = httpx2.post(f"{sites.url}/stop?robot=/{site}", json={"latch": False}, timeout=30, trust_env=False)
    assert answer.status_code == 200, answer.text
    return time.monotonic() - began


def withstand(sites: Sites, name: str, sender: str, target: str, stopped: str) -> None:
    """Stop a site through the hub during a flood, and after it. What is flooded does not grow."""
    calm = [stop_once(sites, stopped) for _ in range(5)]
    instance = sites.instance(target)
    processes = [sites.process("hub" if name in AT_HUB else target)]
    before = [memory(process.pid) for process in processes]
    during: list[float] = []
    with flooding(name, sites.broker.url_for(sender), target, instance, sites.folder):
        began = time.monotonic()
        while time.monotonic() - began < FLOOD_SECONDS or len(during) < 10:
            during.append(stop_once(sites, stopped))
            time.sleep(0.02)
    after = [stop_once(sites, stopped) for _ in range(5)]
    grown = max(memory(process.pid) - size for process, size in zip(processes, before, strict=True))
    ended = time.monotonic()
    sites.wait_for_all()  # a site that floods the hub in its own name may be lost meanwhile
    followed_after = time.monotonic() - ended
    figures = {
        "stops": len(during),
        **{
            f"stop {when}, median / worst, ms": f"{1000 * quantile(values, 0.5):.0f} / {1000 * max(values):.0f}"
            for when, values in (("before", calm), ("during", during), ("after", after))
        },
        "megabytes": round(grown),
        "all sites followed after, s": round(followed_after),
    }
    report(f"NATS: {name}", figures)
    assert max(during) < STOPPED_WITHIN
    assert max(after) < STOPPED_WITHIN
    assert followed_after < 30
    assert grown < 60


@pytest.mark.parametrize("name", AT_SITE)
def test_a_flood_of_a_site(flooded: Sites, name: str) -> None:
    """What the hub has not signed delays what it has signed by a moment, during the flood and after it."""
    withstand(flooded, name, "hub", "berlin", "berlin")


@pytest.mark.parametrize("name", AT_HUB)
def test_a_flood_of_the_hub_by_a_site(flooded: Sites, name: str) -> None:
    """A hostile site does not keep the hub from the other one."""
    withstand(flooded, name, "oslo", "oslo", "berlin")
