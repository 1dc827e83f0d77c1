"use strict";
// The empirical models, as in squeezefilm.force_model: eqs (7) and (14) of the paper. A point has
// h0_m, hv_m, phi_r_m, phi_deg; theta has five entries, the last two zero with two factors.

// A point with its position in both forms, polar and Cartesian.
function completed(point) {
  if ("x_m" in point) {
    const { x_m, y_m } = point, phi_deg = (Math.atan2(y_m, x_m) * 180) / Math.PI;
    return { ...point, phi_r_m: Math.hypot(x_m, y_m), phi_deg };
  }
  const angle = (point.phi_deg * Math.PI) / 180;
  return { ...point, x_m: point.phi_r_m * Math.cos(angle), y_m: point.phi_r_m * Math.sin(angle) };
}

function positionFactor(theta, point) {
  return 1 + theta[3] * (point.phi_deg / 45) + theta[4] * point.phi_r_m;
}

// Force in newtons; NaN where a root is undefined.
function force(theta, point) {
  const epsilon = point.hv_m / point.h0_m;
  const square = epsilon * epsilon;
  const upper = 1 + theta[0] * square;
  const lower = 1 - theta[1] * positionFactor(theta, point) * square;
  return upper >= 0 && lower > 0 ? Math.sqrt(upper) / Math.sqrt(lower) + theta[2] : NaN;
}

// Amplitude in metres that gives the wanted force at a point's gap and position, below contact;
// NaN where there is none.
function amplitudeForForce(theta, point, wanted_n) {
  const g = (wanted_n - theta[2]) ** 2;
  const square = (g - 1) / (theta[0] + g * theta[1] * positionFactor(theta, point));
  if (!(square >= 0 && square < 1)) return NaN;
  const hv_m = Math.sqrt(square) * point.h0_m;
  const reached = force(theta, { ...point, hv_m });
  // Squaring brings in a false solution, on the other branch of the root.
  return Math.abs(reached - wanted_n) <= 1e-9 * (1 + Math.abs(wanted_n)) ? hv_m : NaN;
}
