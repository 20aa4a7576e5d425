"""Agreement between the best methods of the formulations, of a benchmark."""

from __future__ import annotations

from dubins_study.report.elements.content import BENCHMARK, Topic
from dubins_study.report.topics.agreement import formulations_section

TOPIC = Topic("agreement of formulations", formulations_section, BENCHMARK)
