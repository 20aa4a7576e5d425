"use strict";
// The frame of the page: the contents list follows the reading, and folds away on a phone.
(() => {
  // Scripts add to a page that is complete without them; styles show what only works with them.
  document.documentElement.classList.add("scripted");
  const list = document.querySelector("#contents details");
  const links = new Map();
  for (const link of document.querySelectorAll("#contents a")) {
    if (link.hash && link.getAttribute("href").startsWith("#")) links.set(link.hash.slice(1), link);
  }
  const parts = [...links.keys()].map((id) => document.getElementById(id)).filter(Boolean);
  const here = document.getElementById("here");
  const narrow = window.matchMedia("(max-width: 68.74rem)"); // as in style.css
  let current = null;

  // The last part whose top is above a third of the screen; at the page's end the last one.
  function readPart() {
    const line = window.innerHeight / 3;
    const page = document.scrollingElement;
    if (page.scrollTop > 0 && page.scrollTop + window.innerHeight >= page.scrollHeight - 2) {
      return parts[parts.length - 1];
    }
    let read = parts[0];
    for (const part of parts) {
      if (part.getBoundingClientRect().top > line) break;
      read = part;
    }
    return read;
  }

  function follow() {
    const part = readPart();
    if (!part || part.id === current) return;
    if (current !== null) links.get(current).removeAttribute("aria-current");
    current = part.id;
    const link = links.get(current);
    link.setAttribute("aria-current", "true");
    here.textContent = `: ${link.textContent}`;
    if (!narrow.matches) {
      // Only the list itself scrolls: scrollIntoView would move the page as well.
      const box = document.getElementById("contents");
      const top = link.offsetTop - box.clientHeight / 2;
      if (box.scrollHeight > box.clientHeight) box.scrollTop = top;
    }
  }

  let waiting = false;
  function onScroll() {
    if (waiting) return;
    waiting = true;
    window.requestAnimationFrame(() => {
      waiting = false;
      follow();
    });
  }

  function fold() {
    list.open = !narrow.matches;
  }
  list.addEventListener("click", (event) => {
    if (narrow.matches && event.target.closest("a")) list.open = false;
  });
  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && narrow.matches && list.open) {
      list.open = false;
      list.querySelector("summary").focus();
    }
  });
  narrow.addEventListener("change", fold);

  // A link into the details opens every folded part around its target, and scrolls there. When a
  // script has filled the page above, the link scrolls again unless the reader has begun to move.
  let moved = false;
  for (const kind of ["wheel", "touchmove", "keydown", "pointerdown"]) {
    window.addEventListener(kind, () => { moved = true; }, {once: true, passive: true});
  }
  function land() {
    const target = document.getElementById(window.location.hash.slice(1));
    if (!target) return;
    const inside = target.querySelector(":scope > details.part");
    if (inside) inside.open = true;
    for (let box = target.closest("details"); box; box = box.parentElement.closest("details")) {
      box.open = true;
    }
    target.scrollIntoView();
  }
  function landAgain() {
    if (!moved) land();
  }
  window.addEventListener("hashchange", land);
  window.addEventListener("load", landAgain);
  document.addEventListener("laidout", landAgain);
  land();

  document.addEventListener("scroll", onScroll, {passive: true});
  window.addEventListener("resize", onScroll);
  fold();
  follow();
})();
