// Bounds of routes by comrob/gdip, for benchmarks/route_peers.py.
//
// One line of input a route: finest resolution, limit in seconds, heading at the first point, number
// of points, points in turning radii. One line of output: seconds, lower bound, length of the best path
// as the library reports it, its headings, resolution reached.
//
// The intervals of headings are made finer as in the library's examples: those on the cheapest chain
// are halved until it has none wider than 2 pi / resolution, then the resolution doubles. A path goes
// through the right ends of the intervals.
#include <chrono>
#include <cstdio>
#include <iostream>
#include <limits>
#include <vector>

#include "opendubins/dubins.h"

using opendubins::AngleInterval;
using opendubins::Dubins;
using opendubins::Point;

typedef std::vector<std::vector<AngleInterval>> Intervals;  // of each point
typedef std::vector<std::vector<double>> Table;             // lengths of a leg between intervals
typedef std::chrono::steady_clock Clock;

static double bound(const AngleInterval& a, const AngleInterval& b) {
    return Dubins(a, b, 1.0).length;
}

static double sample(const AngleInterval& a, const AngleInterval& b) {
    return Dubins(a.getRightState(), b.getRightState(), 1.0).length;
}

// The least sum over all chains; `chain` gets the interval at each point.
static double cheapest(const std::vector<Table>& legs, std::vector<int>& chain) {
    const size_t n = legs.size();
    std::vector<double> cost(legs[0].size(), 0.0);
    std::vector<std::vector<int>> before(n);
    for (size_t i = 0; i < n; ++i) {
        const size_t ends = legs[i][0].size();
        std::vector<double> total(ends, std::numeric_limits<double>::infinity());
        before[i].assign(ends, 0);
        for (size_t j = 0; j < cost.size(); ++j)
            for (size_t k = 0; k < ends; ++k)
                if (cost[j] + legs[i][j][k] < total[k]) {
                    total[k] = cost[j] + legs[i][j][k];
                    before[i][k] = static_cast<int>(j);
                }
        cost = total;
    }
    chain.assign(n + 1, 0);
    for (size_t k = 1; k < cost.size(); ++k)
        if (cost[k] < cost[chain[n]]) chain[n] = static_cast<int>(k);
    const double least = cost[chain[n]];
    for (size_t i = n; i > 0; --i) chain[i - 1] = before[i - 1][chain[i]];
    return least;
}

// Halve the intervals on the chain that are wider than 2 pi / resolution; false if there is none.
static bool halve(Intervals& points, std::vector<Table>& legs, const std::vector<int>& chain,
                  int resolution) {
    std::vector<bool> split(points.size(), false);
    bool any = false;
    for (size_t i = 0; i < points.size(); ++i) {
        AngleInterval& interval = points[i][chain[i]];
        if (interval.resolution < 1 || interval.resolution >= resolution) continue;
        const AngleInterval left = interval.splitInterval();
        points[i].push_back(left);
        split[i] = any = true;
    }
    for (size_t i = 0; i < legs.size(); ++i) {
        const std::vector<AngleInterval>&a = points[i], &b = points[i + 1];
        legs[i].resize(a.size());
        for (size_t j = 0; j < a.size(); ++j) {
            const bool row = split[i] && (j + 1 == a.size() || static_cast<int>(j) == chain[i]);
            legs[i][j].resize(b.size());
            for (size_t k = 0; k < b.size(); ++k)
                if (row || (split[i + 1] &&
                            (k + 1 == b.size() || static_cast<int>(k) == chain[i + 1])))
                    legs[i][j][k] = bound(a[j], b[k]);
        }
    }
    return any;
}

int main() {
    int finest, count;
    double limit, heading;
    while (std::cin >> finest >> limit >> heading >> count) {
        Intervals points;
        for (int i = 0; i < count; ++i) {
            double x, y;
            std::cin >> x >> y;
            points.push_back(std::vector<AngleInterval>(1, AngleInterval(Point(x, y))));
        }
        points[0][0] = AngleInterval(points[0][0].point, heading, 0.0);
        const Clock::time_point began = Clock::now();
        std::vector<Table> legs(count - 1, Table(1, std::vector<double>(1)));
        for (int i = 0; i + 1 < count; ++i) legs[i][0][0] = bound(points[i][0], points[i + 1][0]);
        std::vector<int> chain;
        double low = cheapest(legs, chain);
        int reached = 1;
        bool late = false;
        for (int resolution = 2; resolution <= finest && !late; resolution *= 2) {
            while (!late && halve(points, legs, chain, resolution)) {
                low = cheapest(legs, chain);
                late = std::chrono::duration<double>(Clock::now() - began).count() > limit;
            }
            if (!late) reached = resolution;
        }
        for (int i = 0; i + 1 < count; ++i)
            for (size_t j = 0; j < points[i].size(); ++j)
                for (size_t k = 0; k < points[i + 1].size(); ++k)
                    legs[i][j][k] = sample(points[i][j], points[i + 1][k]);
        const double length = cheapest(legs, chain);
        const double seconds = std::chrono::duration<double>(Clock::now() - began).count();
        std::printf("%.9g %.17g %.17g", seconds, low, length);
        for (int i = 0; i < count; ++i) std::printf(" %.17g", points[i][chain[i]].getRight());
        std::printf(" %d\n", reached);
    }
}
