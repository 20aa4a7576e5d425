"""The topic `matrix` of the report."""

from dubins_study.report.topics.matrix.section import TOPIC

__all__ = ["TOPIC"]
