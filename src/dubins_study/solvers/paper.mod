# The shortest path of a Dubins vehicle to a point: model (4.12), order {order}.
# Lengths are in the unit of x0, y0, xT, yT and R; angles in radians, counter-clockwise from +x.

param x0 := {scenario.x!r};      # start
param y0 := {scenario.y!r};
param theta0 := {scenario.heading!r};      # heading at the start
param xT := {scenario.target_x!r};      # target
param yT := {scenario.target_y!r};
param R := {scenario.radius!r};      # minimum turning radius
param b := {curvature};      # curvature of the first turn, to the {first}

# The starting point faces the target. Without it AMPL starts at zero, where the gradients of the
# two constraints are linearly dependent.
var z1 >= 0, := {z[0]!r};      # length of the first turn, to the {first}
var z2 >= 0, := {z[1]!r};      # length of the second turn, to the {second}
var z3 >= 0, := {z[2]!r};      # length of the straight

var theta1 = theta0 + b * z1;      # heading after the first turn
var theta2 = theta1 - b * z2;      # heading after the second turn

minimize f: z1 + z2 + z3;

# (4.10)
subject to x_end:
    xT - x0 - (1 / b) * (-sin(theta0) + 2 * sin(theta1) - sin(theta2)) - z3 * cos(theta2) = 0;

# (4.11)
subject to y_end:
    yT - y0 - (1 / b) * (cos(theta0) - 2 * cos(theta1) + cos(theta2)) - z3 * sin(theta2) = 0;

# A full turn in an arc is never shortest, but it is a local minimum. To exclude it:
# subject to cap1: z1 <= 8 * atan(1) * R;
# subject to cap2: z2 <= 8 * atan(1) * R;

# option solver ipopt;
# solve;
# display z1, z2, z3, f;
