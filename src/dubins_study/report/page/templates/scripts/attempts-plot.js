"use strict";
// The plot of attempts, drawn by Bokeh: chosen solvers in the colours and markers of their engines,
// all others faint below them.
(() => {
  const {element} = window.studyTables;
  const {FIELDS, marks, number, unpacked} = window.attempts;
  const MOST_HITS = 50; // points at one place that the drawer leads through
  const MOST_TOOLTIPS = 3;
  const NARROW = () => innerWidth < 640; // CSS pixels

  let library = null;
  function loadBokeh() {
    library ??= (async () => {
      for (const name of ["bokeh", "bokeh-api"]) {
        const text = await unpacked(name);
        document.head.append(element("script", {textContent: text}));
      }
      window.Bokeh.set_log_level("error");
      return window.Bokeh;
    })();
    return library;
  }

  function css(name) {
    return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  }

  // {values, floor} of a field: the values of all rows as they are drawn. On a logarithmic axis,
  // values up to 0 are drawn at `floor`, a decade below all others; `floor` is null if there are
  // none.
  const known = new Map();
  function axisValues(data, name) {
    if (!known.has(name)) {
      const {value, log} = FIELDS[name], values = new Float64Array(data.count);
      let least = Infinity, zeros = false;
      for (let i = 0; i < data.count; i += 1) {
        values[i] = value(data, i);
        if (values[i] > 0) least = Math.min(least, values[i]);
        else if (values[i] <= 0) zeros = true;
      }
      const floor = log && zeros ? 10 ** (Math.floor(Math.log10(Math.min(least, 1))) - 1) : null;
      if (floor !== null) values.forEach((v, i) => { if (v <= 0) values[i] = floor; });
      known.set(name, {values, floor});
    }
    return known.get(name);
  }

  function axisTitle(data, name) {
    const {floor} = axisValues(data, name), {title, short} = FIELDS[name];
    const zero = floor === null ? "" : `0 is drawn at ${number(floor, 1)}`;
    return NARROW() ? [short, zero].filter(Boolean).join("\n") : [title, zero].filter(Boolean).join("; ");
  }

  // {chosen, others, without}: the rows that pass the filters and have finite values, of chosen
  // solvers and of others; and how many rows of chosen solvers have no such values.
  function rows(data, state) {
    const x = axisValues(data, state.x).values, y = axisValues(data, state.y).values;
    const chosen = new Set(state.chosen), {solver} = data.columns;
    const result = {chosen: [], others: [], without: 0};
    for (let i = 0; i < data.count; i += 1) {
      const coloured = chosen.has(solver[i] - 1);
      if (!coloured && !state.others) continue;
      if (!state.texts.every(([name, set]) => set.has(data.anyText(name, i)))) continue;
      if (Number.isFinite(x[i]) && Number.isFinite(y[i])) result[coloured ? "chosen" : "others"].push(i);
      else if (coloured) result.without += 1;
    }
    return result;
  }

  function columns(data, state, list) {
    const x = axisValues(data, state.x).values, y = axisValues(data, state.y).values;
    return {x: list.map((i) => x[i]), y: list.map((i) => y[i]), row: list};
  }

  function marked(data, state, list) {
    const looks = marks(data, state.chosen), each = list.map((i) => looks.get(data.columns.solver[i] - 1));
    return {
      ...columns(data, state, list),
      marker: each.map((look) => look.marker), angle: each.map((look) => look.angle),
      colour: each.map((look) => css(look.colour)), fill: each.map((look) => look.fill),
      size: each.map((look) => look.size),
    };
  }

  // The element that is shown beside a point. Texts of the rows are set as text, never as HTML.
  function tooltip(data, state, i, here) {
    const solver = data.solvers[data.columns.solver[i] - 1];
    const line = (text, style = "") => element("div", {style}, text);
    const value = (name) => `${FIELDS[name].short}: ${number(FIELDS[name].value(data, i))}`;
    return element("div", {className: "attempt-tooltip", style: "background: var(--paper); "
      + "color: var(--ink); margin: -5px; padding: 6px 9px; max-width: 21rem; overflow-wrap: anywhere"},
    line(solver.label, "font-weight: 600"), line(solver.spec, "font-family: monospace; color: var(--muted)"),
    line([data.anyText("verdict", i), data.anyText("claim", i) && `claim ${data.text("claim", i)}`,
      data.anyText("label", i) || data.anyText("region", i)].filter(Boolean).join(", ")),
    line(`${value(state.y)}; ${value(state.x)}`), line(here));
  }

  function figure(Bokeh, data, state, sources) {
    const kind = (name) => (FIELDS[name].log ? "log" : "linear");
    const coarse = matchMedia("(pointer: coarse)").matches;
    const fig = Bokeh.Plotting.figure({x_axis_type: kind(state.x), y_axis_type: kind(state.y),
      height: NARROW() ? 380 : 500, sizing_mode: "stretch_width", toolbar_location: "above",
      tools: "", background_fill_color: css("--paper"), border_fill_color: css("--paper"),
      outline_line_color: css("--rule"), min_border_right: 12});
    const zoom = new Bokeh.BoxZoomTool(), wheel = new Bokeh.WheelZoomTool({modifiers: {ctrl: true}});
    const faint = fig.scatter({field: "x"}, {field: "y"}, {source: sources.others, size: 4,
      marker: "circle", fill_color: css("--muted"), fill_alpha: 0.22, line_color: null});
    const bright = fig.scatter({field: "x"}, {field: "y"}, {source: sources.chosen, size: {field: "size"},
      marker: {field: "marker"}, angle: {field: "angle"}, fill_color: {field: "colour"},
      fill_alpha: {field: "fill"}, line_color: {field: "colour"}, line_width: 1.2});
    fig.scatter({field: "x"}, {field: "y"}, {source: sources.current, size: 18, marker: "circle",
      fill_color: null, line_color: css("--ink"), line_width: 2});
    for (const renderer of [faint, bright]) {
      renderer.nonselection_glyph = null;
      renderer.selection_glyph = null;
    }
    // Where the pointer is on coloured points, the faint points below have no tooltip.
    const above = () => sources.chosen.inspected.indices.length > 0;
    const hover = new Bokeh.HoverTool({renderers: [bright, faint], limit: MOST_TOOLTIPS,
      filters: {row: (_, {data_source}) => data_source === sources.chosen || !above()},
      tooltips: (source, {index, indices}) => tooltip(data, state, source.get_column("row")[index],
        index === indices[0] && indices.length > MOST_TOOLTIPS ? `the first of ${indices.length} here` : "")});
    fig.add_tools(zoom, new Bokeh.PanTool(), wheel, new Bokeh.ResetTool(), hover,
      new Bokeh.TapTool({renderers: [bright, faint]}));
    Object.assign(fig.toolbar, {logo: null, active_scroll: wheel, active_drag: coarse ? null : zoom});
    style(fig, data, state);
    return fig;
  }

  function style(fig, data, state) {
    const ink = css("--ink"), muted = css("--muted"), font = getComputedStyle(document.body).fontFamily;
    for (const [axis, name] of [[fig.xaxis, state.x], [fig.yaxis, state.y]]) {
      Object.assign(axis, {axis_label: axisTitle(data, name), axis_label_text_color: ink,
        axis_label_text_font: font, axis_label_text_font_size: "13px", axis_label_text_font_style: "normal",
        major_label_text_color: muted, major_label_text_font: font, major_label_text_font_size: "12px",
        axis_line_color: muted, major_tick_line_color: muted, minor_tick_line_color: null});
    }
    for (const grid of [fig.xgrid, fig.ygrid]) grid.grid_line_color = css("--rule");
  }

  // Draw into `place`. `tapped(rows)` is called with the rows at a place that is clicked, `moved()`
  // when the axes have moved. Returns {update(kind), inFrame(), mark(row), reset(), figure(),
  // shown()}.
  async function plot(place, data, state, {tapped, moved}) {
    const Bokeh = await loadBokeh();
    let sources = null, view = null, fig = null, shown = rows(data, state), current = -1;

    function fillSources() {
      shown = rows(data, state);
      sources.others.data = columns(data, state, shown.others);
      sources.chosen.data = marked(data, state, shown.chosen);
      mark(current);
    }

    function mark(i) {
      current = i;
      sources.current.data = columns(data, state, i < 0 ? [] : [i]);
    }

    function hits() {
      const each = [sources.chosen, sources.others].flatMap((one) => {
        const {indices} = one.selected, list = one.get_column("row");
        const rowsHere = [...indices].map((k) => list[k]);
        if (indices.length) one.selected.indices = [];
        return rowsHere;
      });
      if (each.length) tapped(each.slice(0, MOST_HITS));
    }

    // Each figure gets new sources: Bokeh lets no two documents share a model.
    function newSources() {
      const source = (more) => new Bokeh.ColumnDataSource({data: {x: [], y: [], row: [], ...more}});
      sources = {others: source(), current: source(),
        chosen: source({marker: [], angle: [], colour: [], fill: [], size: []})};
      let waiting = null;
      for (const one of [sources.chosen, sources.others]) {
        one.selected.properties.indices.change.connect(() => {
          if (!one.selected.indices.length) return;
          clearTimeout(waiting);
          waiting = setTimeout(hits, 0); // by then both layers have set their selection
        });
      }
    }

    async function draw() {
      newSources();
      fillSources();
      fig = figure(Bokeh, data, state, sources);
      let moving = null;
      for (const range of [fig.x_range, fig.y_range]) {
        range.change.connect(() => {
          clearTimeout(moving);
          moving = setTimeout(moved, 150);
        });
      }
      const before = view, next = element("div");
      place.append(next);
      view = await Bokeh.Plotting.show(fig, next);
      if (before) {
        before.remove();
        place.firstChild.remove();
      }
    }

    // The coloured rows within the axes, the largest on the vertical axis first.
    function inFrame() {
      const x = axisValues(data, state.x).values, y = axisValues(data, state.y).values;
      const within = (value, {start, end}) => !(value < Math.min(start, end) || value > Math.max(start, end));
      return shown.chosen.filter((i) => within(x[i], fig.x_range) && within(y[i], fig.y_range))
        .sort((a, b) => y[b] - y[a]);
    }

    async function update(kind) {
      if (kind === "axes" || kind === "theme") await draw();
      else fillSources();
    }

    await draw();
    return {update, inFrame, mark, reset: () => view.reset(), figure: () => fig, shown: () => shown};
  }

  Object.assign(window.attempts, {plot});
})();
