"use strict";
// What is known of a modulated amplitude at a point of the centred pad: the films of the study's
// plan around it (modulation.py), between whose numbers those of the point are taken to lie.

// The levels that hold a value between them, or the one that it is at; none outside of all.
function between(levels, value) {
  const slack = 1e-9 * Math.abs(value);
  const at = levels.find((level) => Math.abs(level - value) <= slack);
  if (at !== undefined) return [at];
  const above = levels.findIndex((level) => level > value);
  return above > 0 ? [levels[above - 1], levels[above]] : [];
}

// The films around a point, or why there are none that say something.
function modulationAt(modulation, point) {
  const gaps = between(modulation.h0_m, point.h0_m), amplitudes = between(modulation.hv_m, point.hv_m);
  if (!gaps.length || !amplitudes.length) return { films: [], why: "outside the films that were examined" };
  const corners = gaps.flatMap((h0_m) => amplitudes.map((hv_m) => [h0_m, hv_m]));
  const films = corners.map(([h0_m, hv_m]) =>
    modulation.films.find((film) => film.h0_m === h0_m && film.hv_m === hv_m));
  const unknown = films.find((film) => !film || film.why);
  if (unknown !== undefined) return { films: [], why: unknown.why };
  if (films.includes(undefined)) return { films: [], why: "not all films around it were examined" };
  return { films, why: "" };
}

// Least and largest of films' numbers.
function reach(films, number) {
  const values = films.map(number);
  return [Math.min(...values), Math.max(...values)];
}
