"use strict";
// The plot of the embedded attempts, drawn by Bokeh when it comes into view.
(() => {
  const place = document.getElementById("attempts-plot");
  if (!place) return;
  const {element} = window.studyTables;
  const {unpacked, open} = window.attempts;

  // What an axis can show: title with its unit, and the value of a row. All but angles are
  // logarithmic.
  const scaled = (name) => (data, i) => data.columns[name][i] / data.ofScenario("radius", i);
  const plain = (name) => (data, i) => data.columns[name][i];
  const FIELDS = {
    gap: ["gap to the reference length (relative)", plain("gap")],
    miss: ["distance from the path's end to the target (R)", scaled("miss")],
    wall_s: ["time of the whole attempt (s)", plain("wall_s")],
    solve_s: ["time in the solver (s)", plain("solve_s")],
    evaluations: ["function evaluations", plain("evaluations")],
    length: ["length of the path (R)", scaled("length")],
    margin: ["distance from the target to the nearer turning circle (R)",
      (data, i) => data.ofScenario("margin", i) ?? NaN],
    radius: ["turning radius (length unit)", (data, i) => data.ofScenario("radius", i)],
  };

  function css(name) {
    return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  }

  async function loadBokeh() {
    for (const name of ["bokeh", "bokeh-api"]) {
      const text = new TextDecoder().decode(await unpacked(name));
      document.head.append(element("script", {textContent: text}));
    }
  }

  async function start() {
    const [data] = await Promise.all([open(), loadBokeh()]);
    const {figure, show} = window.Bokeh.Plotting;
    const fig = figure({x_axis_type: "log", y_axis_type: "log", height: 480, sizing_mode: "stretch_width",
      tools: "pan,wheel_zoom,box_zoom,reset,tap,hover"});
    const x = [], y = [];
    for (let i = 0; i < data.count; i += 1) {
      x.push(FIELDS.margin[1](data, i));
      y.push(Math.max(FIELDS.gap[1](data, i), 1e-17));
    }
    const source = new window.Bokeh.ColumnDataSource({data: {x, y}});
    fig.scatter({field: "x"}, {field: "y"}, {source, size: 4, fill_color: css("--blue"), line_color: null});
    fig.xaxis.axis_label = FIELDS.margin[0];
    fig.yaxis.axis_label = FIELDS.gap[0];
    await show(fig, place);
    place.dataset.ready = "yes";
  }

  const watcher = new IntersectionObserver((entries) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    watcher.disconnect();
    start();
  }, {rootMargin: "300px"});
  watcher.observe(place);
})();
