"""The topic `bias` of the report."""

from dubins_study.report.topics.bias.section import TOPIC

__all__ = ["TOPIC"]
