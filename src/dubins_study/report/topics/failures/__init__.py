"""The topic `failures` of the report."""

from dubins_study.report.topics.failures.section import TOPIC

__all__ = ["TOPIC"]
