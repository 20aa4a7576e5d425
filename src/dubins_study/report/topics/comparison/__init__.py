"""The topic `comparison` of the report."""

from dubins_study.report.topics.comparison.section import TOPIC

__all__ = ["TOPIC"]
