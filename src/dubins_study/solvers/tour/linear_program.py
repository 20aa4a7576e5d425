"""The tour as a mixed-integer linear program.

It is the generalised travelling salesman problem. x is 1 on each arc that is driven. As many arcs
reach a node as leave it, and one leaves each place. The models differ in the way that they forbid
subtours:

- `flow`: a commodity of which each place but the start takes one (Gavish and Graves 1978).
- `mtz`: positions of the places (Miller, Tucker and Zemlin 1960).
- `cuts`: rows that are added where a subtour is found (Dantzig, Fulkerson and Johnson 1954).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import block_array, csr_array, hstack, vstack

from dubins_study.solvers.tour.graph import Graph
from dubins_study.study.arrays import BoolArray, FloatArray, IntArray

FLOW = "flow"
MTZ = "mtz"
CUTS = "cuts"
MODELS = (FLOW, MTZ, CUTS)


class LinearProgram(NamedTuple):
    """A mixed-integer linear program.

    min cost z subject to least <= rows z <= most and low <= z <= high. The z with a true entry in
    `whole` are whole numbers.
    """

    cost: FloatArray  # shape (n,); the arcs come first
    rows: csr_array
    least: FloatArray
    most: FloatArray
    low: FloatArray
    high: FloatArray
    whole: BoolArray


def program_of(graph: Graph, model: str) -> LinearProgram:
    """The program of a graph with one of `MODELS`.

    The program of `cuts` has no row against subtours.
    """
    nodes = graph.owner.size
    places = graph.places.count
    arcs = np.arange(graph.costs.size)
    i, j = graph.pairs
    leave = _ones(graph.tails, arcs, nodes)
    reach = _ones(graph.heads, arcs, nodes)
    passed = places
    if graph.places.in_order:
        passed = 1  # the rows of the others follow from the first
    once = np.concatenate((np.zeros(nodes), np.ones(passed)))
    degrees = LinearProgram(
        cost=graph.costs,
        rows=csr_array(vstack([leave - reach, _ones(i, arcs, places)[:passed]])),
        least=once,
        most=once,
        low=np.zeros(arcs.size),
        high=np.ones(arcs.size),
        whole=np.ones(arcs.size, np.bool_),
    )
    if model == CUTS:
        return degrees
    codes, pair_of = np.unique(i * places + j, return_inverse=True)
    # a row of z adds up the arcs of one pair of places (i, j): 1 if the place j follows i
    z = _ones(pair_of, arcs, codes.size)
    i, j = np.divmod(codes, places)
    if model == FLOW:
        return _with_flow(degrees, z[j > 0], i[j > 0], j[j > 0])
    inner = (i > 0) & (j > 0)
    return _with_positions(degrees, z[inner], i[inner], j[inner], places)


def _ones(rows: IntArray, columns: IntArray, height: int) -> csr_array:
    """A matrix of zeros, with ones at given places.

    Its shape is (height, columns.size).
    """
    return csr_array((np.ones(rows.size), (rows, columns)), shape=(height, columns.size))


def _with_flow(program: LinearProgram, z: csr_array, i: IntArray, j: IntArray) -> LinearProgram:
    """The program with a flow per pair (i, j).

    Each place but the start keeps one unit. Where j does not follow i (a row of `z`), the flow is
    0. Elsewhere it is at most the number of places that are left to be passed. No flow goes to the
    start.
    """
    flows = np.arange(i.size)
    places = int(j.max()) + 1
    net_inflow = (_ones(j, flows, places) - _ones(i, flows, places))[1:]
    most = np.where(i == 0, places - 1.0, places - 2.0)
    # the rows: what each place keeps, then the limit of each flow
    return _extended(
        program,
        [[None, net_inflow], [z.multiply(-most[:, None]), _ones(flows, flows, i.size)]],
        least=np.concatenate((np.ones(places - 1), np.full(i.size, -np.inf))),
        most=np.concatenate((np.ones(places - 1), np.zeros(i.size))),
        high=most,
    )


def _with_positions(
    program: LinearProgram, z: csr_array, i: IntArray, j: IntArray, places: int
) -> LinearProgram:
    """The program with the position of each place.

    If j follows i (a row of `z`), the position of j is at least 1 more than that of i.
    """
    rows = np.arange(i.size)
    ahead = (_ones(i, rows, places) - _ones(j, rows, places)).T
    most = places - 2.0
    return _extended(
        program,
        [[(most + 1.0) * z, ahead]],
        least=np.full(i.size, -np.inf),
        most=np.full(i.size, most),
        high=np.full(places, most),
    )


def _extended(
    program: LinearProgram,
    blocks: list[list[Any]],
    least: FloatArray,
    most: FloatArray,
    high: FloatArray,
) -> LinearProgram:
    """The program with more rows and variables.

    `blocks` are the new rows over the old and the new variables, `least` and `most` their ends. The
    new variables are from 0 to `high` and cost nothing.
    """
    zeros = np.zeros(high.size)
    no_entries = csr_array((program.least.size, high.size))
    return LinearProgram(
        cost=np.concatenate((program.cost, zeros)),
        rows=csr_array(vstack([hstack([program.rows, no_entries]), block_array(blocks)])),
        least=np.concatenate((program.least, least)),
        most=np.concatenate((program.most, most)),
        low=np.concatenate((program.low, zeros)),
        high=np.concatenate((program.high, high)),
        whole=np.concatenate((program.whole, zeros > 0.0)),
    )


def with_cuts(program: LinearProgram, graph: Graph, subtours: list[list[int]]) -> LinearProgram:
    """The program with a row for each subtour.

    Of the arcs that leave a subtour's places at least one is driven.
    """
    i, j = graph.pairs
    rows = []
    for nodes in subtours:
        places = graph.owner[nodes]
        rows.append(np.isin(i, places) & ~np.isin(j, places))
    cuts = np.ones(len(rows))
    return _extended(
        program,
        [[csr_array(np.array(rows, np.float64))]],
        least=cuts,
        most=np.inf * cuts,
        high=cuts[:0],
    )
