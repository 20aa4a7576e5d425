"use strict";
// The section of single attempts: choice, plot, legend and list together, once it comes into view.
(() => {
  const place = document.getElementById("attempts-plot");
  if (!place) return;
  const {element} = window.studyTables;
  const {open, choice, marks, swatch, plot, list, show, whenNear, FIELDS} = window.attempts;

  async function start() {
    const data = await open();
    const canvas = element("div", {className: "canvas"}), legend = element("ul", {className: "marks"});
    canvas.setAttribute("role", "group");
    canvas.setAttribute("aria-label", "plot of attempts; the table below lists its coloured points");
    const status = element("p", {className: "note"});
    status.setAttribute("role", "status");
    const points = list(data);
    let drawn = null;
    const {form, state} = choice(data, (kind) => changed(kind));
    const reset = element("button", {type: "button", className: "reset"}, "show all of the plot");
    form.append(" ", reset);
    reset.addEventListener("click", () => drawn && drawn.reset());
    place.append(form, canvas, legend, status, points.node);

    function legendEntry([k, look]) {
      const {label, spec} = data.solvers[k];
      const drop = element("button", {type: "button", title: spec, ariaLabel: `no longer colour ${label}`},
        "×");
      drop.addEventListener("click", () => state.drop(k));
      return element("li", {title: spec}, swatch(look), element("span", {}, label), drop);
    }

    function describe() {
      legend.replaceChildren(...[...marks(data, state.chosen)].map(legendEntry));
      const {chosen, others, without} = drawn.shown();
      const missing = without ? `; ${without} more have no ${FIELDS[state.y].short} or no `
        + `${FIELDS[state.x].short}` : "";
      status.textContent = `${chosen.length} coloured points and ${others.length} faint ones${missing}.`
        + " Drag a box to zoom, or turn the wheel with Ctrl held; click a point for its path.";
      points.update(drawn.inFrame());
    }

    async function changed(kind) {
      if (!drawn) return;
      await drawn.update(kind);
      describe();
    }

    drawn = await plot(canvas, data, state, {
      tapped: (rows) => show(data, rows),
      moved: () => drawn && points.update(drawn.inFrame()),
    });
    describe();
    window.attempts.drawn = drawn;
    document.addEventListener("attempt", ({detail}) => drawn.mark(detail));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => changed("theme"));
    place.dataset.ready = "yes";
    document.dispatchEvent(new Event("laidout"));
  }

  whenNear(place, start);
})();
