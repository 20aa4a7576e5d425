"""The topic `map` of the report."""

from dubins_study.report.topics.map.section import TOPIC

__all__ = ["TOPIC"]
