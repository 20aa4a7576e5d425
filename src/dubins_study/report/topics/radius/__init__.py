"""The topic `radius` of the report."""

from dubins_study.report.topics.radius.section import TOPIC

__all__ = ["TOPIC"]
