"""benchopt's side: one data set a cell.

The environment says how many there are.
"""

import os

from benchopt import BaseDataset

from benchmarks.overhead.trivial import targets


class Dataset(BaseDataset):
    name = "targets"
    parameters = {"target_x": targets(int(os.environ.get("OVERHEAD_CELLS", "2")))}  # noqa: RUF012

    def get_data(self):
        return {"target_x": self.target_x}
