"""The topic `caution` of the report."""

from dubins_study.report.topics.caution.section import TOPIC

__all__ = ["TOPIC"]
