"""The topic `decision` of the report."""

from dubins_study.report.topics.decision.section import TOPIC

__all__ = ["TOPIC"]
