"""The topic `convergence` of the report."""

from dubins_study.report.topics.convergence.section import TOPIC

__all__ = ["TOPIC"]
