"""Who runs what: files that need a processor for themselves one at a time, those that wait for robots beside them."""

from xdist.scheduler import LoadFileScheduling
from xdist.workermanage import WorkerController

BUSY = ("tests/chaos/", "tests/browser/")
"""Browsers and floods: two at once would wait for each other, and measure that."""


class Turns(LoadFileScheduling):  # type: ignore[misc] # xdist has no types
    """Gives each worker whole files, in their order, but no busy file to one while another one has one."""

    def _assign_work_unit(self, node: WorkerController) -> None:
        if any(self._is_busy(other) for other in self.nodes if other is not node):
            calm = next((file for file in self.workqueue if not file.startswith(BUSY)), None)
            if calm is not None:
                self.workqueue.move_to_end(calm, last=False)
        super()._assign_work_unit(node)

    def _is_busy(self, node: WorkerController) -> bool:
        return any(file.startswith(BUSY) and not all(done.values()) for file, done in self.assigned_work[node].items())
