"""One adapter for each engine that solves mixed-integer nonlinear programs and proves a bound."""
