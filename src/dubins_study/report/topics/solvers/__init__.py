"""The topic `solvers` of the report."""

from dubins_study.report.topics.solvers.section import TOPIC

__all__ = ["TOPIC"]
