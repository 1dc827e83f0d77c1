"use strict";
// How far a fitted model is to be trusted at a point: the rule of squeezefilm.models.trust, from the
// numbers of its Trust.to_dict. A point has h0_m, hv_m and its position in both forms.

function placed(trust, point) {
  const { widths } = trust;
  return [
    point.h0_m / widths.h0_m, point.hv_m / widths.hv_m,
    point.hv_m / point.h0_m / widths.epsilon,
    point.x_m / widths.x_m, point.y_m / widths.y_m,
  ];
}

// The simulations that the fit never saw, each where distances are taken.
function unseenOf(trust) {
  const { force_n, error_n, ...factors } = trust.unseen;
  return force_n.map((_, i) => {
    const own = Object.entries(factors).map(([name, values]) => [name, values[i]]);
    const point = completed(Object.fromEntries(own));
    const square = (point.hv_m / point.h0_m) ** 2, error = Math.abs(error_n[i]);
    return {
      ...point, force_n: force_n[i], error_n: error_n[i], error, square, over: error / square,
      place: placed(trust, point),
    };
  });
}

// The names of what lies outside the ranges of the fitted points.
function outsideOf(trust, point) {
  const values = { ...point, epsilon: point.hv_m / point.h0_m }, slack = 1e-9;
  const reach = trust.ranges.phi_r_m;
  return Object.keys(trust.ranges).filter((name) => {
    const [low, high] = trust.ranges[name];
    const give = slack * Math.max(Math.abs(low), Math.abs(high));
    const out = values[name] < low - give || values[name] > high + give;
    return out && !(name === "phi_deg" && point.phi_r_m <= slack * reach[1]);
  });
}

// What is known of the model's error at a point, with its force there: the bound in newtons, the
// nearest unseen simulation, the distance to it, what lies outside, and whether it is trusted.
function judge(trust, unseen, point, force_n, most) {
  const outside = outsideOf(trust, point), at = placed(trust, point);
  const square = (point.hv_m / point.h0_m) ** 2;
  const enough = unseen.length >= trust.least_points;
  let nearest = null, least = Infinity, plain = Infinity, scaled = Infinity;
  for (const each of unseen) {
    let sum = 0;
    for (let i = 0; i < at.length; i += 1) sum += (at[i] - each.place[i]) ** 2;
    const away = Math.sqrt(sum);
    if (away < least) [nearest, least] = [each, away];
    if (!enough) continue;
    plain = Math.min(plain, each.error + trust.steepness[0] * away);
    scaled = Math.min(scaled, each.over + trust.steepness[1] * away);
  }
  const size = Math.abs(force_n);
  const error_n = Math.min(plain, scaled * square)
    + (trust.simulation_error + trust.scan_error) * size;
  const trusted = enough && !outside.length && error_n <= most * size;
  return { error_n, within: error_n / size, nearest, distance: least, outside, enough, trusted };
}
