"""The topic `discretisation` of the report."""

from dubins_study.report.topics.discretisation.section import TOPIC

__all__ = ["TOPIC"]
