"""The topic `proofs` of the report."""

from dubins_study.report.topics.proofs.section import TOPIC

__all__ = ["TOPIC"]
