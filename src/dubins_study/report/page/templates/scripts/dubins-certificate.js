"use strict";
// window.dubins.certificate(heading, word, segments): whether a path satisfies Pontryagin's
// conditions, and how far it stays from its cut.
//
// The formulas of study/check/two_arcs.py (docs/derivation.md, sections 9 and 10), for `segments` in
// radii (for an arc: rad). tests/browser/test_dubins_script.py compares both.
window.dubins.certificate = (() => {
  const FULL_TURN = 2 * Math.PI;
  const RATE = {L: 1, S: 0, R: -1}; // curvature times radius
  // Those of the check. A piece that is shorter than NO_LENGTH (radii) and turns by less than
  // NO_TURN (rad) is left out of a certificate.
  const {ARRIVES, DRIVEN, NO_TURN, NO_LENGTH} = window.tolerances;
  const {PMP_TOLERANCE, PMP_ROUNDING, CUT_TOLERANCE, ABNORMAL} = window.tolerances;

  // Pontryagin's conditions and the cut for a word S, C, CS or CC at full rate (derivation,
  // sections 9 and 10): {verdict, extremal, residual, hamiltonian, sign_margin, costate_x,
  // costate_y, abnormal, cut_margin}. Costates are in the world's frame with nu0 = 1, or of norm 1
  // if abnormal; residuals are for max(nu0, |(nu1, nu2)|) = 1; the cut margin is in rad. The verdict
  // is "shortest", "beyond its cut" (an extremal that another path beats) or "no extremal".
  function certificate(heading, word, segments) {
    const pieces = mattering([...word].map((letter, i) => [RATE[letter], segments[i]]));
    if (!pieces.length) {
      return {verdict: "shortest", extremal: true, residual: 0, hamiltonian: null,
        sign_margin: null, costate_x: null, costate_y: null, abnormal: false, cut_margin: Math.PI};
    }
    const measured = costates(...pieces[0], ...(pieces[1] || [0, 0]));
    const {nu0, rho, phi, hamiltonian, sign_margin, cut_margin} = measured;
    const abnormal = nu0 < ABNORMAL, size = abnormal ? rho : rho / nu0;
    const cos = Math.cos(heading), sin = Math.sin(heading);
    const along = Math.cos(phi), across = Math.sin(phi);
    const residual = Math.max(hamiltonian, -sign_margin);
    const total = segments.reduce((sum, length) => sum + length, 0);
    const extremal = residual <= PMP_TOLERANCE + PMP_ROUNDING * total;
    const clear = cut_margin >= -CUT_TOLERANCE;
    return {
      verdict: clear && extremal ? "shortest" : extremal ? "beyond its cut" : "no extremal",
      extremal, residual, hamiltonian, sign_margin,
      costate_x: size * (cos * along - sin * across),
      costate_y: size * (sin * along + cos * across),
      abnormal, cut_margin,
    };
  }

  // The pieces [rate, length in radii] without those that are next to nothing, if the path then ends
  // where it did to within ARRIVES radii (study/check/extremal.py:pieces).
  function mattering(pieces) {
    const total = pieces.reduce((sum, [, length]) => sum + length, 0);
    const merged = [];
    for (const [rate, length] of pieces) {
      const turns = Math.abs(rate) * length > NO_TURN;
      if (!turns && length <= NO_LENGTH * Math.min(1, total)) continue;
      const kept = turns ? rate : 0, last = merged[merged.length - 1];
      if (last && last[0] === kept) last[1] += length;
      else merged.push([kept, length]);
    }
    const [driven, other] = [pieces, merged].map(end);
    const same = Math.hypot(driven.x - other.x, driven.y - other.y) <= ARRIVES + DRIVEN * total;
    const named = merged.length < 2 || merged[0][0] !== 0; // no straight before a turn
    return same && named ? merged : pieces;
  }

  function end(pieces) {
    const origin = {x: 0, y: 0, heading: 0};
    const rates = pieces.map(([rate]) => rate), lengths = pieces.map(([, length]) => length);
    return window.dubins.poses(origin, rates, lengths)[pieces.length];
  }

  function costates(rate1, first, rate2, second) {
    const middle = rate1 * first, end = middle + rate2 * second;
    let nu0 = 1, rho = -1, phi = end, cut_margin = Math.PI; // S, C, CS: against the final heading
    if (rate2 !== 0) { // CC: along or against the chord of the second arc
      const half = Math.cos(second / 2);
      nu0 = Math.abs(half);
      rho = half < 0 ? 1 : -1;
      phi = middle + rate2 * second / 2;
      const longest = 2 * Math.atan2(-Math.sin(second), 2 - Math.cos(second));
      cut_margin = Math.min(second - Math.PI, FULL_TURN - second, longest - first);
    } else if (rate1 !== 0) {
      cut_margin = 2 * (Math.PI - Math.atan(second)) - first;
    }
    const origin = {x: 0, y: 0, heading: 0};
    const [, after, last] = window.dubins.poses(origin, [rate1, rate2], [first, second]);
    const nu1 = rho * Math.cos(phi), nu2 = rho * Math.sin(phi);
    const startNu3 = nu2 * last.x - nu1 * last.y; // nu3 = 0 at the end
    const middleNu3 = nu2 * (last.x - after.x) - nu1 * (last.y - after.y);
    const before = nu0 + nu1 + rate1 * startNu3; // H on the first piece, and on the second
    const behind = nu0 + rho * Math.cos(middle - phi) + rate2 * middleNu3;
    const still = rate2 === 0 ? Math.abs(middleNu3) / Math.max(1, first + second) : 0;
    const margins = [];
    if (rate1 !== 0) margins.push(least(nu0, rho, -phi, middle - phi));
    if (rate2 !== 0) margins.push(least(nu0, rho, middle - phi, end - phi));
    return {
      nu0, rho, phi, cut_margin,
      hamiltonian: Math.max(Math.abs(before), Math.abs(behind), still),
      sign_margin: margins.length ? Math.min(...margins) : 0,
    };
  }

  // Least nu0 + rho cos(theta) for theta between a and b (rad): -u nu3 on an arc where H = 0.
  function least(nu0, rho, a, b) {
    const low = Math.min(a, b), high = Math.max(a, b), opposite = rho < 0 ? 0 : Math.PI;
    const turns = (angle) => Math.floor((angle - opposite) / FULL_TURN);
    if (turns(high) > turns(low)) return nu0 - Math.abs(rho);
    return nu0 + Math.min(rho * Math.cos(a), rho * Math.cos(b));
  }

  return certificate;
})();
