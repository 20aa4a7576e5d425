"use strict";
// window.explorerLegs(root): the explorer's table and sentences where there are via points or a final
// heading: all six words of one leg, or the leg to each point. `fill(scenario, answer)` returns the
// summary. Everything is set as text.
window.explorerLegs = (root) => {
  const {set, write} = window.svgElements, {number, degrees, segments} = window.explorerNumbers;
  const table = root.querySelector(".explorer-legs"), body = table.tBodies[0], rows = [];
  const named = (name) => root.querySelector(`[data-answer=${name}]`);
  const EXACT = "Exact: the shortest of all six words, each in closed form.";
  const NOT_PROVED = "Not proved: the page has searched the headings at the points, and a shorter route may exist. "
    + "The command below proves an interval around the shortest length.";
  const summary = named("summary"), place = named("place"), first = named("leg"), last = named("leg-note");

  function row(i) {
    if (!rows[i]) {
      const element = body.insertRow(), cells = {};
      element.setAttribute("role", "row");
      for (const [name, kind] of [["leg", "th"], ["path", "td"], ["radii", "td"], ["length", "td"], ["note", "td"]]) {
        cells[name] = element.appendChild(document.createElement(kind));
        set(cells[name], kind === "th" ? {scope: "row", role: "rowheader"} : {role: "cell", "data-cell": name});
      }
      for (const name of ["radii", "length", "note"]) set(cells[name], {class: "number"});
      set(cells.radii, {"data-label": "length, R"});
      set(cells.length, {"data-label": "length"});
      rows[i] = {element, cells};
    }
    return rows[i];
  }

  function fill(scenario, answer) {
    const {kind, entries, headings} = answer;
    const best = kind === "pose" ? entries.find((entry) => entry.optimal) : null, {via} = scenario;
    write(first, best ? "word" : "leg");
    const noted = best ? "over the shortest" : "heading at its end";
    write(last, noted);
    entries.forEach((entry, i) => {
      const {element, cells} = row(i), to = i === via.length ? "T" : i + 1;
      element.classList.toggle("optimal", Boolean(best) && entry.optimal);
      element.classList.toggle("absent", !entry.exists);
      const texts = {
        leg: best ? `${entry.branch}${entry.optimal ? " ✓" : ""}` : `${i || "start"} → ${to}`,
        path: entry.exists ? segments(entry) : "no path",
        radii: entry.exists ? number(entry.length / scenario.radius) : "–",
        length: entry.exists ? number(entry.length) : "–",
        note: best ? over(entry, best) : within(headings[i + 1]),
      };
      for (const [name, text] of Object.entries(texts)) write(cells[name], text);
      set(cells.note, {"data-label": noted});
    });
    rows.forEach(({element}, i) => { element.hidden = i >= entries.length; });
    const text = best ? summaryOf("Shortest", best.word || "nothing to drive", best.length, scenario)
      : summaryOf("Found", entries.map((entry) => entry.word).join(" "),
        entries.reduce((sum, entry) => sum + entry.length, 0), scenario);
    write(summary, text);
    write(place, {pose: () => EXACT, route: () => NOT_PROVED, tour: tourPlace}[kind](answer));
    return text;
  }

  function tourPlace({order, length, given}) {
    const all = order.reduce((product, _, i) => product * (i + 1), 1).toLocaleString("en");
    const places = order.map((i) => i + 1).join(", "), over = number(100 * (given / length - 1), 3);
    const compared = order.every((i, visit) => i === visit) ? "It is the given order."
      : `It is ${places} of the given points; the route found in the given order is ${number(given)} long (+${over} %).`;
    return `The best order found, not proved. ${compared} All ${all} orders were compared on a grid of headings and the best `
      + "few searched; a shorter tour may exist. The command below proves an interval around the shortest length.";
  }

  // A heading within half a turn, without the last digits: 1e-15 for 0 says nothing.
  function within(angle) {
    const turned = Math.atan2(Math.sin(angle), Math.cos(angle));
    return degrees(Math.round(turned * 1e9) / 1e9);
  }

  function over(entry, best) {
    if (!entry.exists) return "–";
    if (entry.optimal) return "shortest";
    return best.length > 0 ? `+${number(100 * (entry.length / best.length - 1), 3)} %` : `+${number(entry.length, 4)}`;
  }

  function summaryOf(title, words, length, {radius}) {
    return `${title}: ${words}, length ${number(length)} (${number(length / radius)} R).`;
  }

  return {fill};
};
