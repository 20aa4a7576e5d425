"use strict";
// The form that chooses what the plot of attempts shows: axes, coloured solvers, regions, strata,
// verdicts and experiments.
(() => {
  const {element} = window.studyTables;
  const {FIELDS} = window.attempts;
  const MOST_SOLVERS = 10; // coloured at a time
  const MOST_STRATA = 40; // labels of scenarios; where there are more, each names one scenario
  const SHAPES = { // markers in a box from -6 to 6; named as Bokeh names them
    circle: "M -4.5 0 A 4.5 4.5 0 1 0 4.5 0 A 4.5 4.5 0 1 0 -4.5 0 Z",
    triangle: "M 0 -5 L 5 4 H -5 Z",
    inverted_triangle: "M 0 5 L 5 -4 H -5 Z",
    square: "M -4 -4 H 4 V 4 H -4 Z",
    diamond: "M 0 -5.5 L 4 0 L 0 5.5 L -4 0 Z",
    plus: "M -1.7 -5 H 1.7 V -1.7 H 5 V 1.7 H 1.7 V 5 H -1.7 V 1.7 H -5 V -1.7 H -1.7 Z",
    square_pin: "M -5 -5 Q 0 -2 5 -5 Q 2 0 5 5 Q 0 2 -5 5 Q -2 0 -5 -5 Z",
    star: "M 0 -5.5 L 1.4 -1.8 H 5.2 L 2.2 0.6 L 3.3 4.5 L 0 2.2 L -3.3 4.5 L -2.2 0.6 L -5.2 -1.8 H -1.4 Z",
    hex: "M -2.5 -4.4 H 2.5 L 5 0 L 2.5 4.4 H -2.5 L -5 0 Z",
  };

  // [opacity of the fill, size in pixels] for the solvers of one engine, in order.
  const VARIANTS = [[0.85, 7], [0, 7], [0.35, 7], [0, 11], [0.85, 4.5], [0.35, 11]];

  // Map each chosen solver to its mark: that of its engine. Solvers of one engine differ in the
  // opacity of the fill and in the size.
  function marks(data, chosen) {
    const used = new Map(), result = new Map();
    for (const k of chosen) {
      const {colour, marker, angle} = data.solvers[k], key = `${colour} ${marker} ${angle}`;
      const turn = used.get(key) || 0;
      used.set(key, turn + 1);
      const [fill, size] = VARIANTS[turn % VARIANTS.length];
      result.set(k, {colour, marker, angle, fill, size});
    }
    return result;
  }

  // A mark as a small drawing, for the legend.
  function swatch({colour, marker, angle, fill, size}) {
    const box = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    box.setAttribute("viewBox", "-7 -7 14 14");
    box.setAttribute("aria-hidden", "true");
    box.setAttribute("class", "swatch");
    const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
    path.setAttribute("d", SHAPES[marker] || SHAPES.circle);
    path.setAttribute("transform", `rotate(${-angle * 180 / Math.PI}) scale(${size / 9})`);
    path.style.stroke = `var(${colour})`;
    path.style.fill = `var(${colour})`;
    path.style.fillOpacity = fill;
    box.append(path);
    return box;
  }

  function axisSelect(state, axis, changed) {
    const select = element("select", {name: axis});
    for (const [name, {title}] of Object.entries(FIELDS)) {
      select.append(element("option", {value: name, selected: state[axis] === name}, title));
    }
    select.addEventListener("change", () => {
      state[axis] = select.value;
      changed("axes");
    });
    return select;
  }

  // A folded list of check boxes, one for each value of a text. Values in `set` are shown; a click
  // changes `set` in place and calls `changed`.
  function textFilter(title, values, set, changed) {
    const summary = element("summary");
    const list = element("fieldset", {}, element("legend", {className: "hidden"}, title));
    const describe = () => {
      const shown = set.size === values.length ? "all" : `${set.size} of ${values.length}`;
      summary.textContent = `${title}: ${shown}`;
    };
    const boxes = values.map((value) => {
      const box = element("input", {type: "checkbox", checked: set.has(value)});
      box.addEventListener("change", () => {
        if (box.checked) set.add(value);
        else set.delete(value);
        describe();
        changed("filter");
      });
      list.append(element("label", {}, box, ` ${value || "none"}`));
      return box;
    });
    const all = element("button", {type: "button"}, "all"), none = element("button", {type: "button"}, "none");
    for (const [button, on] of [[all, true], [none, false]]) {
      button.addEventListener("click", () => {
        boxes.forEach((box, k) => {
          box.checked = on;
          if (on) set.add(values[k]);
          else set.delete(values[k]);
        });
        describe();
        changed("filter");
      });
    }
    list.prepend(element("div", {className: "buttons"}, all, " ", none));
    describe();
    return element("details", {}, summary, list);
  }

  // The form and its state: {x, y, chosen, others, texts: [[column, set of texts], ...]}.
  function choice(data, changed) {
    const state = {x: "margin", y: "gap", chosen: data.opening(), others: true, texts: []};
    const form = element("form", {className: "choice"});
    form.addEventListener("submit", (event) => event.preventDefault());
    form.append(element("div", {className: "axes"},
      element("label", {}, "vertical ", axisSelect(state, "y", changed)),
      element("label", {}, "horizontal ", axisSelect(state, "x", changed))));
    const filters = element("div", {className: "filters"});
    filters.append(window.attempts.solverList(data, state, changed, MOST_SOLVERS));
    for (const [title, name] of [["regions", "region"], ["strata", "label"], ["verdicts", "verdict"],
      ["branches", "branch"], ["experiments", "experiment"]]) {
      const values = data.valuesOf(name);
      if (values.length < 2 || values.length > MOST_STRATA) continue;
      const set = new Set(values);
      state.texts.push([name, set]);
      filters.append(textFilter(title, values, set, changed));
    }
    const others = element("input", {type: "checkbox", checked: true});
    others.addEventListener("change", () => {
      state.others = others.checked;
      changed("filter");
    });
    form.append(filters, element("label", {className: "others"}, others, " show the other solvers, faint"));
    return {form, state};
  }

  Object.assign(window.attempts, {choice, marks, swatch});
})();
