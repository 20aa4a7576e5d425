"""benchopt's side: distance from path end to target."""

from benchopt import BaseObjective

from benchmarks.overhead.trivial import question


class Objective(BaseObjective):
    name = "miss"
    sampling_strategy = "run_once"

    def set_data(self, target_x):
        self.scenario = question(target_x)

    def get_objective(self):
        return {"scenario": self.scenario}

    def evaluate_result(self, path):
        return abs(path.end.x - self.scenario.target_x)

    def get_one_result(self):
        return {"path": None}
