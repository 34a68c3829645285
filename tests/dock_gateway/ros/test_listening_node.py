"""There is one way to subscribe to a topic."""

import re
from pathlib import Path

import dock_gateway

PACKAGE = Path(dock_gateway.__file__).parent


def test_one_module_makes_subscriptions() -> None:
    calls = re.compile(r"\b(create_subscription|Subscription)\(")
    makers = [
        path.relative_to(PACKAGE).as_posix()
        for path in sorted((PACKAGE / "ros").rglob("*.py"))
        if calls.search(path.read_text())
    ]
    others = [path for path in PACKAGE.rglob("*.py") if "create_subscription" in path.read_text()]
    assert makers == ["ros/listening_node.py"]
    assert others == [PACKAGE / "ros/listening_node.py"]
