"use strict";
// The fields of an attempt, which the plot can have as axes; numbers as text; and the command that
// repeats an attempt.
(() => {
  const NUMBERS = ["x", "y", "heading", "target_x", "target_y", "radius", "speed"];

  function inRadii(name) {
    return (data, i) => data.columns[name][i] / data.ofScenario("radius", i);
  }

  function measured(name) {
    return (data, i) => data.columns[name][i];
  }

  function offset(data, i) {
    const {x, y, heading, target_x, target_y, radius, has_target} = data.scenario(i);
    if (!has_target) return [NaN, NaN];
    const dx = (target_x - x) / radius, dy = (target_y - y) / radius;
    const cos = Math.cos(heading), sin = Math.sin(heading);
    return [dx * cos + dy * sin, dy * cos - dx * sin];
  }

  // Fields: title with the unit, short name, value of a row (NaN if it has none), and whether the
  // axis is logarithmic.
  const FIELDS = {
    gap: {title: "gap: length beyond the reference (relative)", short: "gap", log: true,
      value: measured("gap")},
    miss: {title: "miss: from the end of the path to the target (R)", short: "miss (R)", log: true,
      value: inRadii("miss")},
    wall_s: {title: "time of the whole attempt (s)", short: "time (s)", log: true,
      value: measured("wall_s")},
    solve_s: {title: "time in the solver alone (s)", short: "solver's time (s)", log: true,
      value: measured("solve_s")},
    evaluations: {title: "function evaluations", short: "evaluations", log: true,
      value: measured("evaluations")},
    length: {title: "length of the path (R)", short: "length (R)", log: true,
      value: inRadii("length")},
    margin: {title: "margin: from the target to the nearer turning circle (R)",
      short: "margin (R)", log: true, value: (data, i) => data.ofScenario("margin", i) ?? NaN},
    distance: {title: "distance from the start to the target (R)", short: "distance (R)", log: true,
      value: (data, i) => Math.hypot(...offset(data, i))},
    bearing: {title: "direction of the target, from the start heading to the left (degrees)",
      short: "direction (°)", log: false,
      value: (data, i) => {
        const [ahead, left] = offset(data, i);
        return Math.atan2(left, ahead) * 180 / Math.PI;
      }},
    radius: {title: "turning radius (length unit)", short: "radius", log: true,
      value: (data, i) => data.ofScenario("radius", i)},
  };

  // A number with three digits, as the tables of the page show it.
  function number(value, digits = 3) {
    if (value === null || value === undefined || Number.isNaN(value)) return "–";
    if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
    if (value === 0) return "0";
    const [mantissa, power] = value.toExponential(digits - 1).split("e");
    const exponent = Number(power);
    const text = exponent > -4 && exponent < 6
      ? value.toFixed(Math.max(0, digits - 1 - exponent)) : `${mantissa}e${exponent}`;
    return text.replaceAll("-", "−");
  }

  // A duration (s) with a suitable unit.
  function seconds(value) {
    if (!(value >= 0)) return "–";
    const [factor, unit] = [[1, "s"], [1e-3, "ms"], [1e-6, "µs"]].find(([least]) => value >= least)
      || [1e-9, "ns"];
    return `${number(value / factor)} ${unit}`;
  }

  // A word of a command line that a POSIX shell hands on unchanged.
  function quoted(word) {
    return /^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`;
  }

  // The command that asks the same question of the same solver. JavaScript writes a number with as
  // many digits as tell it from its neighbours, so the scenario is the same to the last bit.
  function command(data, i) {
    const [x, y, heading, targetX, targetY, radius, speed] =
      NUMBERS.map((name) => String(data.ofScenario(name, i) ?? "free"));
    const limit = data.columns.limit_s[i];
    const options = {
      "--radius": [radius, "1"],
      "--speed": [speed, "1"],
      "--solver": [data.text("solver", i), "analytic"],
      "--branch": [data.text("branch", i), "best"],
      "--profile": [data.text("profile", i), "default"],
      "--time-limit": [limit ? String(limit) : "60", "60"],
    };
    // more than a turn needs a unit
    const angle = (text) => text + (Math.abs(text) > 2 * Math.PI ? "rad" : "");
    const words = ["dubins-study", "solve", "--from", x, y, angle(heading)];
    const {via_x, via_y, via_heading, final_heading, order, closed} = data.route(i);
    via_x.forEach((via, place) => {
      words.push("--via", String(via), String(via_y[place]));
      const there = via_heading[place] ?? null;
      if (there !== null) words.push("--via-heading", String(place + 1), angle(String(there)));
    });
    if (order === "free") words.push("--order", "free");
    if (closed) words.push("--closed");
    if (final_heading !== null) words.push("--final-heading", `${final_heading}rad`);
    for (const [name, [value, usual]] of Object.entries(options)) {
      if (value !== usual) words.push(name, value);
    }
    if (targetX !== "free") words.push("--", targetX, targetY); // a negative number is no option
    return words.map(quoted).join(" ");
  }

  Object.assign(window.attempts, {FIELDS, number, seconds, command});
})();
