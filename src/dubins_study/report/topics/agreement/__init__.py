"""The topic `agreement` of the report."""

from dubins_study.report.topics.agreement.section import TOPIC

__all__ = ["TOPIC"]
