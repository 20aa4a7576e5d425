"""The topic `success` of the report."""

from dubins_study.report.topics.success.section import TOPIC

__all__ = ["TOPIC"]
