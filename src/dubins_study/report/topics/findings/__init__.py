"""The topic `findings` of the report."""

from dubins_study.report.topics.findings.section import TOPIC

__all__ = ["TOPIC"]
