"""The problem: scenarios, paths, the closed form and the check. Knows no solver."""

from study.path import Path
from study.scenario import Pose, Scenario, ScenarioError

__all__ = ["Path", "Pose", "Scenario", "ScenarioError"]
