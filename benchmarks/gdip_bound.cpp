// Bounds of routes by gdip (github.com/comrob/gdip), an independent program; for a radius of 1.
//
//   g++ -O2 -std=c++11 -I gdip/core/src gdip_bound.cpp gdip/core/src/opendubins/*.cpp -o gdip_bound
//   ./gdip_bound SECONDS < routes.txt > gdip.csv
//
// A line of input: id, number of legs n, start heading, x and y of n + 1 points. A line of output:
// id, lower bound, length of a route. Intervals of headings through which no route can be as short
// as the best one are dropped, and the others halved, until the seconds are up.
#include <chrono>
#include <iostream>
#include <vector>

#include "opendubins/dubins.h"

using namespace opendubins;
using std::vector;

struct Interval {
    double right, width;
};

const double NO_ROUTE = 1e300;
const double SECONDS_A_PAIR = 3e-6;

int main(int, char** argv) {
    const double limit = atof(argv[1]);
    std::cout.precision(12);
    std::string id;
    int n;
    double heading;
    while (std::cin >> id >> n >> heading) {
        vector<Point> points(n + 1);
        for (Point& point : points) std::cin >> point.x >> point.y;
        vector<vector<Interval>> layers(n + 1);
        layers[0] = {{heading, 0}};
        for (int i = 1; i <= n; i++)
            for (int k = 0; k < 16; k++) layers[i].push_back({2 * M_PI * k / 16, 2 * M_PI / 16});
        double low = 0, high = NO_ROUTE, work = 0;
        const auto began = std::chrono::steady_clock::now();
        std::chrono::duration<double> spent(0);
        while (high - low > 1e-7 * high && spent.count() + work * SECONDS_A_PAIR < limit) {
            vector<vector<double>> before(n + 1), after(n + 1), driven(n + 1);
            vector<vector<vector<double>>> bounds(n);
            before[0] = driven[0] = {0};
            for (int i = 0; i < n; i++) {
                const auto &from = layers[i], &to = layers[i + 1];
                bounds[i].assign(from.size(), vector<double>(to.size()));
                before[i + 1] = driven[i + 1] = vector<double>(to.size(), NO_ROUTE);
                for (size_t a = 0; a < from.size(); a++)
                    for (size_t b = 0; b < to.size(); b++) {
                        const Interval &f = from[a], &t = to[b];
                        const AngleInterval out(points[i], f.right, f.width);
                        const AngleInterval in(points[i + 1], t.right, t.width);
                        bounds[i][a][b] = Dubins(out, in, 1.0).getLength();
                        const State first(points[i], f.right + f.width / 2);
                        const State last(points[i + 1], t.right + t.width / 2);
                        const double length = Dubins(first, last, 1.0).getLength();
                        double& best = before[i + 1][b];
                        best = std::min(best, before[i][a] + bounds[i][a][b]);
                        double& route = driven[i + 1][b];
                        route = std::min(route, driven[i][a] + length);
                    }
            }
            after[n].assign(layers[n].size(), 0);
            for (int i = n - 1; i >= 0; i--) {
                after[i].assign(layers[i].size(), NO_ROUTE);
                for (size_t a = 0; a < layers[i].size(); a++)
                    for (size_t b = 0; b < layers[i + 1].size(); b++)
                        after[i][a] = std::min(after[i][a], bounds[i][a][b] + after[i + 1][b]);
            }
            low = std::max(low, after[0][0]);
            for (double length : driven[n]) high = std::min(high, length);
            work = 0;
            for (int i = 1; i <= n; i++) {
                vector<Interval> halves;
                for (size_t a = 0; a < layers[i].size(); a++) {
                    const Interval& whole = layers[i][a];
                    if (before[i][a] + after[i][a] > high + 1e-9) continue;
                    halves.push_back({whole.right, whole.width / 2});
                    halves.push_back({whole.right + whole.width / 2, whole.width / 2});
                }
                layers[i] = halves;
                work += double(layers[i - 1].size()) * halves.size();
            }
            spent = std::chrono::steady_clock::now() - began;
        }
        std::cout << id << "," << low << "," << high << std::endl;
    }
}
