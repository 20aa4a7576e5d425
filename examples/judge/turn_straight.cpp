// Answers the questions of instances.csv: at each point a turn toward the next one, then straight.
//   g++ -O2 -std=c++17 -o turn_straight turn_straight.cpp
//   ./turn_straight < set/instances.csv > answers.csv
// Questions with given headings on the way or a closed path stay without an answer.
#include <cmath>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> parts;
    std::istringstream stream(text);
    for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
    return parts;
}

int main() {
    std::string line;
    std::getline(std::cin, line);
    const auto names = split(line, ',');
    std::cout << "id,curvatures,lengths,claim,start_heading\n";
    while (std::getline(std::cin, line)) {  // no cell of these questions has a comma in it
        std::map<std::string, std::string> row;
        const auto cells = split(line, ',');
        for (size_t i = 0; i < names.size(); ++i) row[names[i]] = i < cells.size() ? cells[i] : "";
        const bool free_start = row["heading"] == "free";
        std::ostringstream curvatures, lengths;
        curvatures.precision(17), lengths.precision(17);
        if (row["final_heading"].empty() && row["via_heading"].empty() && row["closed"] == "false" &&
            row["branch"] == "best") {
            auto xs = split(row["via_x"], ' '), ys = split(row["via_y"], ' ');
            if (!row["target_x"].empty()) xs.push_back(row["target_x"]), ys.push_back(row["target_y"]);
            double x = std::stod(row["x"]), y = std::stod(row["y"]), R = std::stod(row["radius"]);
            double heading = free_start ? 0 : std::stod(row["heading"]);
            for (size_t i = 0; i < xs.size(); ++i) {
                const double dx = std::stod(xs[i]) - x, dy = std::stod(ys[i]) - y;
                const double along = dx * std::cos(heading) + dy * std::sin(heading);
                const double left = dy * std::cos(heading) - dx * std::sin(heading);
                double best = INFINITY, turn = 0, straight = 0, side = 1;
                for (const double s : {1.0, -1.0}) {  // left, right: seen from the circle's centre
                    const double across = s * left - R, square = along * along + across * across - R * R;
                    if (square < 0) continue;  // the point is inside this circle
                    const double rest = std::sqrt(square);
                    double angle = std::atan2(across, along) - std::atan2(-R, rest);
                    angle -= 2 * M_PI * std::floor(angle / (2 * M_PI));
                    if (R * angle + rest < best) best = R * angle + rest, turn = angle, straight = rest, side = s;
                }
                curvatures << side / R << " 0 ";
                lengths << R * turn << ' ' << straight << ' ';
                heading += side * turn, x += dx, y += dy;
            }
        }
        const bool answered = !lengths.str().empty();
        std::cout << row["id"] << ',' << curvatures.str() << ',' << lengths.str() << ','
                  << (answered ? "feasible" : "none") << ',' << (answered && free_start ? "0" : "") << '\n';
    }
}
