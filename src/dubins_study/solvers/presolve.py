"""The presolve: what the geometry of a question says of its words before an engine sees them.

A row that it answers says so, and proves nothing for the engine.
"""

from __future__ import annotations

from dubins_study.solvers.protocol import Question, Solution
from dubins_study.study.body_coordinates import Local, local, power
from dubins_study.study.words import BRANCHES, Claim

WORDS = BRANCHES[1:]


def presolved(question: Question) -> Solution | None:
    """The answer to a question whose word ends nowhere near the target; None to all others."""
    if question.branch == "best":
        return None
    reason = unreachable(local(question.scenario), question.branch)
    if reason is None:
        return None
    message = f"presolve: {reason}"
    return Solution(Claim.INFEASIBLE, iterations=0, evaluations=0, message=message, presolved=True)


def words(branch: str, target: Local, presolve: bool) -> tuple[str, ...]:
    """The words to look for a path among; with `presolve`, without those that cannot exist."""
    named = WORDS if branch == "best" else (branch,)
    if not presolve:
        return named
    return tuple(word for word in named if unreachable(target, word) is None)


def unreachable(target: Local, word: str) -> str | None:
    """Why no path of a word ends at the target, or None.

    C is the centre of the first turn's circle. A tangent of this
    circle lies outside it, so LS and RS end at no target inside. The second turn of LR and RL is on
    a circle of radius 1 whose centre is 2 from C: it passes only targets from 1 to 3 away from C.

    In doubt a word exists: of all targets within delta of the given one (docs/derivation.md,
    section 5) none can be reached where this says so.
    """
    X, Y, delta = target
    side = Y if word[0] == "L" else -Y
    inside = power(X, side, 0.0)
    # A target off by delta in X and in Y moves by sqrt(2) delta, and `inside` by 2 |T - C| times
    # that, where |T - C| <= 1 + |X| + |Y|. Twice as much leaves room for rounding, which moves
    # X, Y and `inside` by less than delta.
    doubt = 6.0 * delta * (1.0 + abs(X) + abs(Y))
    if inside > doubt:
        return f"the target is inside the circle of the first turn, which no {word} path enters"
    if word[1] != "S" and -inside - 8.0 > doubt:
        return f"the target is more than 3 radii from the first turn's centre, beyond any {word}"
    return None
