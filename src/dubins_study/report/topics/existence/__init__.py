"""The topic `existence` of the report."""

from dubins_study.report.topics.existence.section import TOPIC

__all__ = ["TOPIC"]
