"""The topic `cost` of the report."""

from dubins_study.report.topics.cost.section import TOPIC

__all__ = ["TOPIC"]
