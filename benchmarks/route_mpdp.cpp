// Routes by icosac/MPDP, for benchmarks/route_peers.py.
//
// One line of input a route: headings a point, refinements, heading at the first point, number of
// points, points in turning radii. One line of output: seconds, 0 for a lower bound that there is
// none of, length of the path as the library reports it, its headings, refinements.
#include <chrono>
#include <cstdio>
#include <iostream>
#include <vector>

#include <dp.hh>

// The library proposes headings along arcs of the radius 1 / DUBINS_DEFAULT_KMAX, whatever curvature
// it is asked for: each of its source files has a `Kmax` of its own. At this scale they are right.
static const double scale = 1.0 / DUBINS_DEFAULT_KMAX;

int main() {
    int samples, refinements, count;
    double heading;
    while (std::cin >> samples >> refinements >> heading >> count) {
        std::vector<Configuration2> points;
        for (int i = 0; i < count; ++i) {
            double x, y;
            std::cin >> x >> y;
            points.push_back(Configuration2(x * scale, y * scale, i == 0 ? heading : 0.0));
        }
        std::vector<bool> given(count, false);
        given[0] = true;
        const std::chrono::steady_clock::time_point began = std::chrono::steady_clock::now();
        const std::pair<LEN_T, std::vector<Angle>> route =
            DP().solveDP(points, given, {DUBINS_DEFAULT_KMAX}, samples, refinements);
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
        std::printf("%.9g 0 %.17g", seconds, route.first / scale);
        for (const double angle : route.second) std::printf(" %.17g", angle);
        std::printf(" %d\n", refinements);
    }
}
