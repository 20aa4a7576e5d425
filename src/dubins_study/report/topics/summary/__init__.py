"""The topic `summary` of the report."""

from dubins_study.report.topics.summary.section import TOPIC

__all__ = ["TOPIC"]
