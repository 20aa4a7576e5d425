"""The topic `time` of the report."""

from dubins_study.report.topics.time.section import TOPIC

__all__ = ["TOPIC"]
