"""Where the tests of the clients are, and the clients."""

import os
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
# Where scripts/install-clients has put them.
CLIENTS = Path(os.environ.get("CLIENTS", ROOT / ".venv/.stamps/clients")).resolve()
