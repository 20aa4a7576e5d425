"""The topic `paper` of the report."""

from dubins_study.report.topics.paper.section import TOPIC

__all__ = ["TOPIC"]
