"use strict";
// What is done with models, each the code of `squeezefilm export` by its name in MODELS. A point has
// h0_m, hv_m and its position in both forms.
const MODELS = {};

// A point with its position in both forms, polar and Cartesian.
function completed(point) {
  if ("x_m" in point) {
    const { x_m, y_m } = point, phi_deg = (Math.atan2(y_m, x_m) * 180) / Math.PI;
    return { ...point, phi_r_m: Math.hypot(x_m, y_m), phi_deg };
  }
  const angle = (point.phi_deg * Math.PI) / 180;
  return { ...point, x_m: point.phi_r_m * Math.cos(angle), y_m: point.phi_r_m * Math.sin(angle) };
}

// Force in newtons; NaN where the model is undefined.
function force(fit, point) {
  return MODELS[fit.name].force_n(...fit.factors.map((name) => point[name]));
}

// The 95 % or 99 % error of a modelled force, in newtons: PredictionInterval.error_n of
// squeezefilm.models.prediction_interval.
function errorOf(fit, force_n, level = "error_95") {
  const [constant, share] = fit.interval?.[level] ?? [NaN, NaN];
  return constant + share * Math.abs(force_n);
}

// The names of the factors that lie outside the declared space, as PredictionInterval.outside.
function outsideOf(fit, point) {
  const { ranges } = fit.interval, slack = 1e-9;
  return Object.keys(ranges).filter((name) => {
    const [low, high] = ranges[name], give = slack * Math.max(Math.abs(low), Math.abs(high));
    const out = point[name] < low - give || point[name] > high + give;
    return out && !(name === "phi_deg" && point.phi_r_m <= slack * ranges.phi_r_m[1]);
  });
}

// Notes on the regions of a point in which the 95 % error holds few validation points:
// PredictionInterval.coverage_notes.
function coverageNotes(fit, point) {
  const values = { ...point, epsilon: point.hv_m / point.h0_m };
  return fit.low_coverage
    .filter(({ quantity, lower, upper }) =>
      values[quantity] >= (lower ?? -Infinity) && values[quantity] < (upper ?? Infinity))
    .map(({ note }) => note);
}

// Smallest amplitude in metres that gives the target force at a point's gap and position, below
// contact; NaN where there is none: as squeezefilm.models.amplitude_for looks for it.
function amplitudeForForce(fit, point, target_n) {
  const at = (share) => share * point.h0_m * (1 - 1e-12);
  return at(firstRoot((share) => force(fit, { ...point, hv_m: at(share) }) - target_n, target_n));
}

// Widest gap in metres, from the widest of some down to the least or to contact, at which a point's
// amplitude gives the target force; NaN where there is none: gap_for_force of the same module.
function gapForForce(fit, point, target_n, [least_m, most_m]) {
  const low = Math.max(least_m, point.hv_m * (1 + 1e-12));
  if (low >= most_m) return NaN;
  const at = (share) => most_m + share * (low - most_m);
  return at(firstRoot((share) => force(fit, { ...point, h0_m: at(share) }) - target_n, target_n));
}

// The first share from 0 to 1 at which an excess over a target force is zero; NaN without one.
const LOOKED_AT = 100;
function firstRoot(excess, target_n) {
  let low = 0, atLow = excess(0);
  for (let i = 1; i <= LOOKED_AT; i += 1) {
    const high = i / LOOKED_AT, atHigh = excess(high);
    const [a, b] = defined(excess, low, atLow, high, atHigh);
    if (a && a.value * b.value <= 0) {
      const found = root(excess, a, b);
      // The sign may change at a pole, too.
      if (Math.abs(excess(found)) <= 1e-9 * (1 + Math.abs(target_n))) return found;
    }
    [low, atLow] = [high, atHigh];
  }
  return NaN;
}

// The part of an interval, by its ends, in which a function is defined, which it is at one end.
function defined(excess, low, atLow, high, atHigh) {
  const ends = [{ at: low, value: atLow }, { at: high, value: atHigh }];
  const known = ends.filter((end) => !Number.isNaN(end.value));
  if (known.length !== 1) return known;
  const [start] = known;
  let inside = start, outside = start === ends[0] ? high : low;
  for (let i = 0; i < 60; i += 1) {
    const at = (inside.at + outside) / 2, value = excess(at);
    if (Number.isNaN(value)) outside = at;
    else inside = { at, value };
  }
  return start === ends[0] ? [start, inside] : [inside, start];
}

// Where a function changes sign, by bisection down to round-off.
function root(excess, low, high) {
  const rises = low.value <= 0;
  let [a, b] = [low.at, high.at];
  for (let i = 0; i < 60; i += 1) {
    const middle = (a + b) / 2;
    if ((excess(middle) <= 0) === rises) a = middle;
    else b = middle;
  }
  return Math.abs(excess(a)) <= Math.abs(excess(b)) ? a : b;
}
