"""Mutation testing of the modules that keep robots safe: changes them in small ways and runs their unit tests.

A mutant that no test notices survives. Prints a table per module and the survivors; fails if a module's tests kill less
than 90 % of its mutants. Arguments: the areas to test; default: all. Runs one process and takes about half an hour.
"""

import json
import re
import shutil
import subprocess
import sys
from contextlib import chdir
from pathlib import Path

from mutmut.configuration import reset_config
from mutmut.mutation.diff_apply import get_diff_for_mutant
from mutmut.stats import status_by_exit_code

GOAL = 0.9
WORK = Path(".mutation")
# Those of the actions that take milliseconds: the others look at memory and at the clock.
ACTION_TESTS = ("adoption", "cancellation", "delivery", "goal_machine", "results", "submitter", "tracker")
DOCKING = (
    "goal/engine",
    "goal/dock",
    "goal/undock",
    "goal/dock_memory",
    "goal/pace",
    "goal/motion_watch",
    "goal/obstacle_watch",
    "goal/navigation",
    "estimation/clearance",
)
# Area → its modules below backend/, and the unit tests that have to notice the mutants.
AREAS = {
    "actions": (
        [
            f"dock_gateway/goals/{name}.py"
            for name in ("goal_machine", "adoption", "tracker", "submitter", "delivery", "cancellation")
        ],
        [f"tests/dock_gateway/goals/test_{name}.py" for name in ACTION_TESTS],
    ),
    "latch": (
        [f"dock_gateway/latch/{name}.py" for name in ("interlock", "latch_file", "latches")],
        ["tests/dock_gateway/latch"],
    ),
    "stop": (
        [f"dock_gateway/stop/{name}.py" for name in ("stopper", "order")],
        [f"tests/dock_gateway/stop/test_{name}.py" for name in ("stopper", "order")],
    ),
    "docking": (
        [f"docking/{name}.py" for name in DOCKING],
        [
            f"tests/docking/{name}.py"
            for name in (
                "goal/test_engine",
                "goal/test_pace",
                "goal/test_motion_watch",
                "goal/test_obstacle_watch",
                "goal/test_navigation",
                "goal/test_dock",
                "goal/test_dock_stages",
                "goal/test_dock_memory",
                "estimation/test_clearance",
                "goal/test_charging",
                "plans/test_undock",
            )
        ],
    ),
}
# The same for extensions, by their names: one that was taken out has none.
OF_EXTENSIONS = {
    "automation": (
        [f"dock_gateway/extensions/automation/{name}.py" for name in ("policy", "past", "schedule")],
        [f"tests/extensions/automation/test_{name}.py" for name in ("policy", "policy_properties", "schedule")],
    ),
    "missions": (
        [f"dock_gateway/extensions/missions/{name}.py" for name in ("progress", "program")],
        [f"tests/extensions/missions/test_{name}.py" for name in ("progress", "progress_properties", "program")],
    ),
    "chargers": (
        ["dock_gateway/extensions/chargers/policy.py"],
        [f"tests/extensions/chargers/test_{name}.py" for name in ("policy", "policy_properties")],
    ),
}
EXTENSIONS = Path(__file__).parents[1] / "backend/dock_gateway/extensions"
AREAS |= {name: area for name, area in OF_EXTENSIONS.items() if (EXTENSIONS / name).is_dir()}
# Lines that are not mutated, and why.
UNMUTATED = {
    r"\blog\.|\bTasks\(|thread_name_prefix": "text for people",
    r"\bchange\(self|method\.__doc__": "runs while the module is imported, before mutmut can switch a mutant on",
}
# Mutants that behave like the original: the line as mutated, and why nothing can notice it.
EQUIVALENT = {
    "refused = None": "as false as False",
    "self._looking_up = None": "as false as False",
    "self._beginning = None": "as false as False",
    "self._pulsing = None": "as false as False",
    "self._waiting.move_to_end(goal_id, last=None)": "as false as False",
    "for attempt in range(3):": "the second attempt leaves the loop",
}

PYTEST = ["-p", "no:cacheprovider", "--hypothesis-profile=mutation", "--timeout=60"]


def prepare(area: str, sources: list[str], tests: list[str]) -> Path:
    """Make the folder in which mutmut works: it wants the packages in its current folder."""
    folder = WORK / area
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name in (
        "backend/dock_gateway",
        "backend/dock_hub",
        "backend/docking",
        "backend/robot_io",
        "tests",
        "pyproject.toml",
    ):
        (folder / Path(name).name).symlink_to(Path(name).absolute())
    (folder / "frontend").mkdir()
    (folder / "frontend/openapi.json").symlink_to(Path("frontend/openapi.json").absolute())  # the tests read it
    settings = {
        "also_copy": ["frontend"],
        "source_paths": ["dock_gateway", "docking", "robot_io"],
        "only_mutate": sources,
        "pytest_add_cli_args_test_selection": tests,
        "pytest_add_cli_args": PYTEST,
        "do_not_mutate_patterns": list(UNMUTATED),
        # Seconds until a mutant that hangs counts as killed: this many times those of its tests and the constant.
        "timeout_multiplier": ["3"],
        "timeout_constant": ["10"],
    }
    lines = [f"{key} =\n    " + "\n    ".join(values) for key, values in settings.items()]
    (folder / "setup.cfg").write_text("\n".join(["[mutmut]", *lines, ""]))
    return folder


def change(diff: str) -> tuple[str, str]:
    """Return the changed line of a mutant before and after."""
    lines = [line for line in diff.splitlines() if line[:1] in "+-" and line[:3] not in {"+++", "---"}]
    before, after = ([line[1:].strip() for line in lines if line[0] == sign] for sign in "-+")
    return " ".join(before), " ".join(after)


def only_text(before: str, after: str) -> bool:
    """Whether a mutant differs only in a sentence, such as the detail of an error."""
    literals = [re.findall(r'"([^"]*)"', line) for line in (before, after)]
    changed = [old for old, new in zip(*literals, strict=False) if old != new]
    return before.lower() == after.lower().replace("xx", "") and any(" " in text for text in changed)


def judge(source: str) -> tuple[int, int]:
    """Print a module's survivors; return the numbers of its mutants and of the killed ones."""
    results = json.loads(Path(f"mutants/{source}.meta").read_text())["exit_code_by_key"]
    total = killed = len(results)
    for mutant, code in results.items():
        if status_by_exit_code[code] in {"killed", "timeout", "segfault"}:
            continue
        before, after = change(get_diff_for_mutant(mutant, path=source))
        killed -= 1
        if only_text(before, after) or after in EQUIVALENT:
            total -= 1
        else:
            print(f"{status_by_exit_code[code]}: {mutant}\n  - {before}\n  + {after}")
    return total, killed


def main(areas: list[str]) -> int:
    """Test these areas, one after the other."""
    scores = {}
    for area in areas:
        sources, tests = AREAS[area]
        folder = prepare(area, sources, tests)
        print(f"── {area}: the progress is in {folder}/log", flush=True)
        command = [Path(".venv/bin/mutmut").absolute(), "run", "--max-children", "1"]
        with (folder / "log").open("w") as log:
            if subprocess.run(command, cwd=folder, stdout=log, stderr=log, check=False).returncode:
                sys.exit(f"mutmut failed: see {folder}/log")
        with chdir(folder):
            reset_config()
            scores |= {source: judge(source) for source in sources}
    print(f"\n{'module':40} mutants  killed")
    for source, (total, killed) in scores.items():
        print(f"{source:40} {total:7} {killed / total:7.1%}")
    return any(killed < GOAL * total for total, killed in scores.values())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:] or list(AREAS)))
