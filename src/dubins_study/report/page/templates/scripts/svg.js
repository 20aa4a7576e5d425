"use strict";
// window.svgElements: SVG elements, made and changed.
//
// `element(name, attributes, parent)` makes one as its parent's last child. `set(target, attributes)`
// and `write(target, text)` change only values that differ from those written last. A browser lays
// out anew even if an equal value is written, and most of a picture stays while one thing is
// dragged.
window.svgElements = (() => {
  const NAMESPACE = "http://www.w3.org/2000/svg", TEXT = Symbol("text");
  const written = new WeakMap(); // element -> {attribute: value}

  function element(name, attributes, parent) {
    const made = document.createElementNS(NAMESPACE, name);
    set(made, attributes);
    return parent.appendChild(made);
  }

  function before(target) {
    if (!written.has(target)) written.set(target, {});
    return written.get(target);
  }

  function set(target, attributes) {
    const values = before(target);
    for (const name in attributes) {
      if (values[name] !== attributes[name]) target.setAttribute(name, values[name] = attributes[name]);
    }
  }

  // The text of an element, of HTML too.
  function write(target, text) {
    const values = before(target);
    if (values[TEXT] !== text) target.textContent = values[TEXT] = text;
  }

  return {element, set, write};
})();
