"use strict";
(() => {
  // Scripts add to a page that is complete without them; style.css shows what only works with them.
  document.documentElement.classList.add("scripted");
})();
