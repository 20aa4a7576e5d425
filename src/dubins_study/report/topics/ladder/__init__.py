"""The topic `ladder` of the report."""

from dubins_study.report.topics.ladder.section import TOPIC

__all__ = ["TOPIC"]
