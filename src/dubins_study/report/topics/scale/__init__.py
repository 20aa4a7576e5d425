"""The topic `scale` of the report."""

from dubins_study.report.topics.scale.section import TOPIC

__all__ = ["TOPIC"]
