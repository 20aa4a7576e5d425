"use strict";
// The coloured points within the plot's axes as a table: the way to them by keyboard, and for
// readers who do not see the plot.
(() => {
  const {element, enhance} = window.studyTables;
  const {number, seconds, show} = window.attempts;
  const MOST_LINES = 50;

  const COLUMNS = [ // title, kind of the column, text of a cell, number behind it
    ["solver", "text", (data, i) => data.solvers[data.columns.solver[i] - 1].label],
    ["verdict", "text", (data, i) => data.anyText("verdict", i)
      + (data.has("false_claim", i) ? ", false claim" : "")],
    ["gap", "number", (data, i) => number(data.columns.gap[i]), (data, i) => data.columns.gap[i]],
    ["miss (R)", "number", (data, i) => number(miss(data, i)), miss],
    ["time", "number", (data, i) => seconds(data.columns.wall_s[i]), (data, i) => data.columns.wall_s[i]],
    ["margin (R)", "number", (data, i) => number(margin(data, i)), margin],
    ["scenario", "text", (data, i) => data.anyText("label", i) || data.anyText("region", i)],
  ];

  function miss(data, i) {
    return data.columns.miss[i] / data.ofScenario("radius", i);
  }

  function margin(data, i) {
    return data.ofScenario("margin", i) ?? NaN;
  }

  function line(data, i) {
    const cells = COLUMNS.map(([, kind, text, value]) => {
      const cell = element("td", {className: kind}, text(data, i));
      const raw = value ? value(data, i) : NaN;
      if (!Number.isNaN(raw)) cell.dataset.value = String(raw);
      return cell;
    });
    const button = element("button", {type: "button", className: "open"}, cells[0].textContent);
    button.title = data.solvers[data.columns.solver[i] - 1].spec;
    button.addEventListener("click", () => show(data, [i]));
    cells[0].replaceChildren(button);
    return element("tr", {}, ...cells);
  }

  // A folded table; `update(rows)` fills it.
  function list(data) {
    const head = element("tr", {}, ...COLUMNS.map(([title, kind]) =>
      element("th", {className: kind, scope: "col"}, title)));
    const body = element("tbody");
    const table = element("table", {className: "points"}, element("thead", {}, head), body);
    const summary = element("summary");
    const node = element("details", {className: "list"}, summary,
      element("div", {className: "scroll", tabIndex: 0}, table));
    const sorting = enhance(table);

    let shown = null; // equal rows keep their lines, and with them a reader's focus

    function update(rows) {
      if (rows.join() === shown) return;
      shown = rows.join();
      body.replaceChildren(...rows.slice(0, MOST_LINES).map((i) => line(data, i)));
      sorting.update();
      const cut = rows.length > MOST_LINES ? `; the ${MOST_LINES} highest are listed` : "";
      summary.textContent = `the coloured points in the frame as a table: ${rows.length}${cut}`;
    }

    return {node, update};
  }

  Object.assign(window.attempts, {list});
})();
