"""Work that only waits, for measuring what an engine costs."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

from kinolab.studies.orders import Answer, WorkOrder


@dataclass(frozen=True)
class WaitingOrder(WorkOrder):
    """Waits, and uses no processor."""

    seconds: float

    def prepare(self, folder: Path) -> None:
        """Nothing is common to several."""

    def work(self, _: Path) -> Answer:
        """Wait."""
        time.sleep(self.seconds)
        return {"status": "done"}
