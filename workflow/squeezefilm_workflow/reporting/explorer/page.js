"use strict";
(function () {
  const data = JSON.parse(document.getElementById("data").textContent);
  const byId = (id) => document.getElementById(id);
  const [first, second] = data.position, polar = first === "phi_r_m";
  const centre = completed({ [first]: 0, [second]: 0 });
  const simulations = data.simulations.map(([plan, h0_m, hv_m, one, other, force_n]) => completed(
    { plan: data.plans[plan], h0_m, hv_m, [first]: one, [second]: other, force_n }));

  // ---- the space of the simulations ------------------------------------------------------------

  function limits(name, points = simulations) {
    let low = Infinity, high = -Infinity;
    for (const point of points) {
      low = Math.min(low, point[name]);
      high = Math.max(high, point[name]);
    }
    return [low, high];
  }

  const space = {
    h0_m: limits("h0_m"), hv_m: limits("hv_m"),
    [first]: limits(first), [second]: limits(second),
  };

  // Why a model is not validated at a point, where it has a force; an empty text where it is.
  function doubt(fit, point, value) {
    if (point.hv_m >= point.h0_m) return "surface and pad touch, there is no film";
    if (!fit.interval?.error_95) return fit.statement;
    if (!Number.isFinite(value)) return "the model is undefined here";
    return outsideOf(fit, point).map((name) => `${WORDS[name]} lies outside the declared space, `
      + `${range(fit.interval.ranges[name], name)}`).join("; ");
  }

  // ---- what is said of a point -------------------------------------------------------------------

  // A 95 % error of a force, and its two parts where the profile is a scan.
  function errorText(fit, part) {
    const { profile_uncertainty: scan } = fit.interval;
    const parts = scan ? `: ${share(part - scan)} of the force by the model, ${share(scan)} by the scan` : "";
    return `95 % error ${share(part)}${parts}`;
  }

  function placeOf(point) {
    return polar ? `${plain(point.phi_r_m / MM)} mm at ${plain(point.phi_deg)}°`
      : `x ${plain(point.x_m / MM)} mm, y ${plain(point.y_m / MM)} mm`;
  }

  // ---- the controls --------------------------------------------------------------------------------

  const stretch = ([low, high], share) => [low - share * (high - low), high + share * (high - low)];
  const inside = (name) => Math.min(Math.max(data.start[name], space[name][0]), space[name][1]);
  const sliders = {
    h0: { name: "h0_m", unit: UM, step: 0.05, symbol: "µm", range: stretch(space.h0_m, 0.2), value: inside("h0_m") },
    hv: { name: "hv_m", unit: UM, step: 0.01, symbol: "µm", range: [0, stretch(space.hv_m, 0.5)[1]], value: inside("hv_m") },
    "phi-r": polar
      ? { name: "phi_r_m", unit: MM, step: 0.05, symbol: "mm", range: [0, space.phi_r_m[1]], value: 0 }
      : { name: "x_m", unit: MM, step: 0.05, symbol: "mm", range: space.x_m, value: 0, signed: true },
    "phi-phi": polar
      ? { name: "phi_deg", unit: 1, step: 1, symbol: "°", range: [0, space.phi_deg[1]], value: 0 }
      : { name: "y_m", unit: MM, step: 0.05, symbol: "mm", range: space.y_m, value: 0, signed: true },
    target: { name: "force_n", unit: 1, step: 0.01, symbol: "N", range: [0, 2 * data.start.force_n], value: data.start.force_n },
  };
  if (!polar) {
    for (const [id, axis] of [["phi-r", "x"], ["phi-phi", "y"]]) {
      const row = byId(id).closest(".row");
      row.querySelector("label").innerHTML = `pad’s centre along <i>${axis}</i>`;
      row.querySelector(".unit").textContent = "mm";
      byId(`${id}-number`).setAttribute("aria-label", `${axis} in millimetres`);
    }
  }
  const state = { fit: data.fits[0] };

  function round(value, step) {
    return Number((Math.round(value / step) * step).toFixed(6));
  }

  for (const [id, slider] of Object.entries(sliders)) {
    const [low, high] = slider.range.map((value) => round(value / slider.unit, slider.step));
    slider.least = slider.signed ? low : Math.max(low, 0);
    slider.most = Math.max(high, slider.least + slider.step);
    slider.bar = byId(id);
    slider.number = byId(`${id}-number`);
    for (const input of [slider.bar, slider.number]) {
      Object.assign(input, { min: slider.least, max: slider.most, step: slider.step });
    }
    slider.number.step = "any";
    slider.bar.addEventListener("input", () => set(id, Number(slider.bar.value), slider.bar));
    slider.number.addEventListener("input", () => {
      if (slider.number.value !== "" && slider.number.checkValidity()) {
        set(id, Number(slider.number.value), slider.number);
      }
    });
    slider.number.addEventListener("change", () => {
      if (slider.number.value !== "") set(id, Number(slider.number.value));
      show(slider);
    });
    slider.shown = round(slider.value / slider.unit, slider.step);
    show(slider);
  }

  // `value` in the shown unit; `from` is the input that is in use and is left as it is.
  function set(id, value, from) {
    const slider = sliders[id];
    slider.shown = Math.min(Math.max(value, slider.least), slider.most);
    show(slider, from);
    update();
  }

  function show(slider, from) {
    if (from !== slider.bar) slider.bar.value = slider.shown;
    if (from !== slider.number) slider.number.value = Number(slider.shown.toPrecision(10));
    slider.bar.setAttribute("aria-valuetext", `${plain(slider.shown)} ${slider.symbol}`);
  }

  // The point that is set; a model of the centred pad is asked there alone.
  function point() {
    const values = {};
    for (const slider of Object.values(sliders)) values[slider.name] = slider.shown * slider.unit;
    return completed(state.fit.moves ? values : { ...values, [first]: 0, [second]: 0 });
  }

  function showFactors() {
    for (const id of ["phi-r", "phi-phi"]) byId(id).closest(".row").hidden = !state.fit.moves;
  }

  for (const fit of data.fits) byId("fit").add(new Option(fit.label, fit.name));
  byId("fit").addEventListener("change", () => {
    state.fit = data.fits.find((fit) => fit.name === byId("fit").value);
    showFactors();
    update();
  });
  byId("take").addEventListener("click", () => {
    const now = point();
    set("hv", amplitudeForForce(state.fit, now, now.force_n) / UM);
  });
  byId("float").addEventListener("click", () => {
    const now = point();
    set("h0", gapForForce(state.fit, now, now.force_n, state.fit.gaps_m) / UM);
  });

  // ---- the answer ------------------------------------------------------------------------------------

  function update() {
    const now = point(), { fit } = state;
    const value = now.hv_m >= now.h0_m ? NaN : force(fit, now);
    const reason = doubt(fit, now, value);
    const error_n = reason ? NaN : errorOf(fit, value);
    const output = byId("force");
    byId("model").textContent = `${fit.label.replace(", ", " (")})`;
    output.value = "";
    if (Number.isFinite(value)) {
      const [digits, error] = toItsError(value, error_n);
      const fine = document.createElement("span");
      fine.className = "fine";
      fine.textContent = error ? ` ±\u00a0${error}\u00a0N` : " (error not known)";
      output.append(digits, "\u00a0N", fine);
    } else {
      output.value = now.hv_m >= now.h0_m ? "no force" : "not known";
    }
    output.dataset.newtons = Number.isFinite(value) ? String(value) : "";
    const validation = byId("validation");
    validation.classList.toggle("doubtful", reason !== "");
    validation.innerHTML = reason ? "<b>Not validated:</b> " : "<b>Validated:</b> ";
    const validated = [errorText(fit, error_n / Math.abs(value)), ...coverageNotes(fit, now)];
    validation.append(reason || `${validated.join("; ")}. ${fit.statement}`);
    const validity = data.inertia.reynolds_per_h0_square * now.h0_m ** 2;
    byId("validity").hidden = !(validity > data.inertia.most_reynolds);
    byId("validity").textContent = `Re ${plain(validity, 2)} at this gap: ${data.inertia.beyond}`;
    const error99 = errorOf(fit, value, "error_99");
    byId("error").textContent = !reason && Number.isFinite(error99) ? `${toItsError(0, error99)[1]} N` : "–";
    sayLoad(fit, now);
    byId("epsilon").textContent = (now.hv_m / now.h0_m).toFixed(3);
    drawSoon();
  }

  // What carries the load: the amplitude at this gap, the gap at this amplitude.
  function sayLoad(fit, now) {
    const gaps = fit.gaps_m;
    for (const [id, button, slider, name, found, none] of [
      ["amplitude", "take", "hv", "hv_m", amplitudeForForce(fit, now, now.force_n), noAmplitude],
      ["gap", "float", "h0", "h0_m", gapForForce(fit, now, now.force_n, gaps), noGap],
    ]) {
      const known = Number.isFinite(found);
      byId(id).textContent = known
        ? lengthText(fit, { ...now, [name]: found }, name) : none(fit, now, gaps);
      byId(id).dataset.metres = known ? String(found) : "";
      const { least, most } = sliders[slider];
      byId(button).disabled = !(known && found / UM >= least && found / UM <= most);
    }
  }

  function noAmplitude(fit, now) {
    const atContact = force(fit, { ...now, hv_m: now.h0_m * (1 - 1e-12) });
    const where = Number.isFinite(atContact) ? "below contact" : "where the model is defined";
    return `none ${where} gives ${plain(now.force_n)} N`;
  }

  function noGap(fit, now, [least, most]) {
    if (now.hv_m >= most) return "none: surface and pad touch at every gap of the space";
    const at = (h0_m) => force(fit, { ...now, h0_m });
    const low = Math.max(least, now.hv_m * (1 + 1e-12)), narrow = at(low), wide = at(most);
    const fitted = `the space’s ${range([least, most], "h0_m")}`;
    if (wide > now.force_n) return `above ${fitted}: at the widest the film gives ${plain(wide, 3)} N`;
    if (narrow < now.force_n) return `none in ${fitted}: at ${plain(low / UM)} µm it gives ${plain(narrow, 3)} N`;
    return `none in ${fitted}`;
  }

  // A gap or an amplitude with the digits that the force's error leaves it; three, and no error, where
  // the model is not validated.
  function lengthText(fit, there, name) {
    const doubted = doubt(fit, there, there.force_n) !== "";
    const error = doubted ? NaN : lengthError(fit, there, name) / UM;
    const [digits, around] = toItsError(there[name] / UM, error);
    const force_n = `for ${plain(there.force_n)} N`;
    if (doubted) return `${digits} µm ${force_n} (not validated)`;
    return `${digits} µm ± ${around} µm ${force_n}, without the modelling error`;
  }

  // The error of a gap or an amplitude that gives the target force: the force's over the slope.
  function lengthError(fit, there, name) {
    const at = (share) => force(fit, { ...there, [name]: share * there[name] });
    const slope = (at(1.0001) - at(0.9999)) / (0.0002 * there[name]);
    return errorOf(fit, there.force_n) / Math.abs(slope);
  }

  // How far films on the grid around the point differ from each other is how far its numbers are known.
  function sayModulation(now) {
    if (!data.modulation) return [];
    const { films, why } = modulationAt(data.modulation, now);
    const about = byId("modulation");
    const moved = now.phi_r_m > 0 ? " The pad is centred here, not at this position." : "";
    if (!films.length) {
      about.textContent = `Not known here: ${why}.`;
      return films;
    }
    const [slow, fast, corner] = [["static_gain", 3], ["instantaneous_gain", 3], ["corner_hz", 2]].map(
      ([name, digits]) => span(reach(films, (film) => film[name]), digits));
    // The gains' error grows with the frequency: at the corner, and where the drawing ends.
    const frequency_hz = data.modulation.frequency_hz;
    const [, highestCorner] = reach(films, (film) => film.corner_hz);
    const last = frequency_hz.findLast((_, i) => films.every((film) => film.gain[i] !== null));
    const errorAt = (hz) => {
      const place = frequency_hz.findIndex((each) => each >= Math.min(hz, last));
      return share(reach(films, (film) => film.error[place])[1]);
    };
    const errors = last === undefined ? "" : ` Error of the gains by period averaging: `
      + `${errorAt(highestCorner)} at the corner, ${errorAt(last)} at ${plain(last)} Hz.`;
    const source = films.length > 1 ? `between the ${films.length} films examined around this point`
      : "for this film";
    about.textContent = `${slow} for slow modulation, ${fast} far above the corner at about ${corner} Hz, `
      + `${source}.${moved}${errors} Inertia and thermal effects of the gas are neglected.`
      + (byId("validity").hidden ? "" : " At this gap the neglected effects rule the film.");
    return films;
  }

  function span([least, most], digits) {
    const [low, high] = [plain(least, digits), plain(most, digits)];
    return low === high ? low : `${low} to ${high}`;
  }

  // ---- the drawings ------------------------------------------------------------------------------------

  let waiting = false;
  function drawSoon() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      const now = point(), ink = colours();
      drawPlane(now, ink);
      drawSpace(now, ink);
      drawGain(now, ink);
    });
  }

  function colours() {
    const style = getComputedStyle(document.documentElement);
    const names = ["card", "ink", "soft", "line", "blue", "red", "shade", "dot"];
    return Object.fromEntries(names.map((n) => [n, style.getPropertyValue(`--${n}`).trim()]));
  }

  function steps([low, high], count) {
    return Array.from({ length: count }, (_, i) => low + ((high - low) * i) / (count - 1));
  }

  const CELLS = 40;
  const seen = { h0: [sliders.h0.least, sliders.h0.most], hv: [0, sliders.hv.most] };
  const FONT = { family: "system-ui, Segoe UI, Roboto, DejaVu Sans, sans-serif", size: 13 };
  const CONFIG = { displayModeBar: false, responsive: true, scrollZoom: false };
  const inUm = (points, name) => points.map((each) => each[name] / UM);

  // Points of one pad position that were simulated as a plan: what a surface can be seen beside.
  const positions = new Map();
  for (const each of simulations) {
    const key = each.phi_r_m === 0 ? "0" : `${each[first]} ${each[second]}`;
    if (!positions.has(key)) positions.set(key, []);
    positions.get(key).push(each);
  }
  const crowd = {};
  for (const each of simulations) crowd[each.plan] = (crowd[each.plan] || 0) + 1;

  function visible(fit, now) {
    const { x_m, y_m } = fit.moves ? now : centre;
    let best = [], least = Infinity;
    for (const points of positions.values()) {
      const distance = Math.hypot(points[0].x_m - x_m, points[0].y_m - y_m);
      if (points.length > 2 && distance < least) [best, least] = [points, distance];
    }
    const drawn = best.filter((each) => crowd[each.plan] <= 300);
    const used = drawn.filter((each) => each.plan === fit.plan);
    return { at: best[0], used, others: drawn.filter((each) => each.plan !== fit.plan) };
  }

  function validated(fit, now) {
    const h0 = steps(space.h0_m, CELLS + 1), hv = steps(space.hv_m, CELLS + 1);
    const middle = (edges, i) => (edges[i] + edges[i + 1]) / 2;
    const at = (i, j) => ({ ...now, h0_m: middle(h0, i), hv_m: middle(hv, j) });
    const z = Array.from({ length: CELLS }, (_, j) => Array.from({ length: CELLS }, (_, i) =>
      (doubt(fit, at(i, j), force(fit, at(i, j))) === "" ? 1 : null)));
    return { x: h0.map((v) => v / UM), y: hv.map((v) => v / UM), z };
  }

  // The surface up to the largest simulated force, or half as much again as the target force: lines
  // of equal gap, each with as many points.
  const highest_n = Math.max(1.5 * data.start.force_n, 1.05 * limits("force_n")[1]);
  function sheet(fit, at) {
    const h0 = steps(seen.h0, 41), share = steps([0, 1], 41);
    const most = h0.map((gap) => {
      const top = amplitudeForForce(fit, { ...at, h0_m: gap * UM }, highest_n) / UM;
      return Math.min(seen.hv[1], Number.isFinite(top) ? top : 0.99 * gap);
    });
    const x = share.map(() => h0), y = share.map((each) => most.map((top) => each * top));
    const z = y.map((row) => row.map((hv, i) => {
      const value = force(fit, { ...at, h0_m: h0[i] * UM, hv_m: hv * UM });
      return Number.isFinite(value) ? value : null;
    }));
    return { x, y, z };
  }

  const kept = { key: "" };
  function positionOf(fit, now) {
    const key = [fit.name, now[first], now[second]].join(" ");
    if (kept.key !== key) {
      const surface = sheet(fit, fit.moves ? now : centre);
      Object.assign(kept, { key, surface, validated: validated(fit, now), points: visible(fit, now) });
    }
    return kept;
  }

  const hover = "h₀ %{x:.3~f} µm, hᵥ %{y:.3~f} µm";

  function dots(points, ink, fill, name) {
    return {
      type: "scatter", mode: "markers", name, x: inUm(points, "h0_m"), y: inUm(points, "hv_m"),
      marker: { size: 7, color: fill, line: { color: ink.ink, width: 1 } },
      hovertemplate: `${hover}<br>%{text}<extra>simulation</extra>`,
      text: points.map((each) => `${each.force_n.toPrecision(4)} N`),
    };
  }

  function axis(title, ink, limits) {
    return {
      title: { text: title, standoff: 8 }, range: limits, color: ink.ink, gridcolor: ink.line,
      linecolor: ink.soft, mirror: true, showline: true, zeroline: false, ticks: "outside",
      tickcolor: ink.soft, fixedrange: true,
    };
  }

  function drawPlane(now, ink) {
    const { fit } = state, { validated: region, points } = positionOf(fit, now);
    const h0 = steps(seen.h0, 200);
    const curve = h0.map((each) => amplitudeForForce(fit, { ...now, h0_m: each * UM }, now.force_n) / UM);
    // Where the model is validated; elsewhere its error is not known.
    const error = h0.map((each, i) => {
      const there = { ...now, h0_m: each * UM, hv_m: curve[i] * UM };
      const known = Number.isFinite(curve[i]) && !doubt(fit, there, now.force_n);
      return known ? lengthError(fit, there, "hv_m") / UM : null;
    });
    const edge = (sign) => ({
      type: "scatter", mode: "lines", name: "its error", hoverinfo: "skip", showlegend: false, x: h0,
      y: curve.map((hv, i) => (error[i] === null ? null : hv + sign * error[i])),
      line: { color: ink.blue, width: 1 },
    });
    Plotly.react("plane", [
      {
        type: "heatmap", ...region, showscale: false, hoverinfo: "skip",
        colorscale: [[0, ink.shade], [1, ink.shade]], zmin: 0, zmax: 1,
      },
      dots(points.others, ink, ink.dot, "simulated"),
      dots(points.used, ink, ink.ink, "fitted"),
      edge(-1), edge(1),
      {
        type: "scatter", mode: "lines", name: `${plain(now.force_n)} N`, x: h0, y: curve,
        line: { color: ink.blue, width: 3 }, hovertemplate: `${hover}<extra>${plain(now.force_n)} N</extra>`,
      },
      thisPoint(now, ink),
    ], planeLayout(ink), CONFIG);
  }

  function thisPoint(now, ink) {
    return {
      type: "scatter", mode: "markers", name: "this point", x: [now.h0_m / UM], y: [now.hv_m / UM],
      marker: { symbol: "diamond", size: 15, color: ink.red, line: { color: ink.card, width: 2 } },
      hovertemplate: `${hover}<extra>this point</extra>`,
    };
  }

  function planeLayout(ink) {
    return {
      font: { ...FONT, color: ink.ink }, paper_bgcolor: ink.card, plot_bgcolor: ink.card,
      margin: { l: 56, r: 12, t: 8, b: 50 }, dragmode: false, hovermode: "closest",
      xaxis: axis("mean gap <i>h</i><sub>0</sub> (µm)", ink, seen.h0),
      yaxis: axis("amplitude <i>h</i><sub>v</sub> (µm)", ink, seen.hv),
      legend: { orientation: "h", x: 0, y: 1.01, yanchor: "bottom", bgcolor: "rgba(0,0,0,0)" },
    };
  }

  // Seen from farther away where the page is narrow.
  const view = { azimuth: -130, distance: innerWidth < 500 ? 3.2 : 1.9, height: 0.85 };
  function eye() {
    const angle = (view.azimuth * Math.PI) / 180;
    return { x: view.distance * Math.cos(angle), y: view.distance * Math.sin(angle), z: view.height };
  }

  // Drawing in space needs WebGL, which some browsers lack.
  const solid = (() => {
    const canvas = document.createElement("canvas");
    try {
      return Boolean(canvas.getContext("webgl") || canvas.getContext("experimental-webgl"));
    } catch {
      return false;
    }
  })();
  if (!solid) {
    byId("drawn").textContent = "lines of equal force";
    byId("wrong").textContent = "Where a dot’s colour stands off from that around it, the model is "
      + "wrong. (This browser has no WebGL, which a surface in space needs.)";
    byId("turn").closest(".turn").hidden = true;
  }

  function drawContours(now, ink) {
    const { fit } = state, { points } = positionOf(fit, now), at = fit.moves ? now : { ...now, ...centre };
    const x = steps(seen.h0, 61), y = steps(seen.hv, 61);
    const z = y.map((hv) => x.map((h0) => {
      const value = hv < h0 ? force(fit, { ...at, h0_m: h0 * UM, hv_m: hv * UM }) : NaN;
      return value <= highest_n ? value : null;
    }));
    const known = z.flat().filter((value) => value !== null);
    const scale = { colorscale: "Viridis", cmin: Math.min(...known), cmax: Math.max(...known) };
    const cloud = (some, line, name) => {
      const trace = dots(some, ink, some.map((each) => each.force_n), name);
      return { ...trace, marker: { ...trace.marker, ...scale, line: { color: line, width: 1.5 } } };
    };
    Plotly.react("space", [
      {
        type: "contour", x, y, z, colorscale: "Viridis", zmin: scale.cmin, zmax: scale.cmax,
        connectgaps: false, contours: { coloring: "heatmap", showlabels: true, labelfont: { color: "#fff" } },
        colorbar: { title: { text: "force (N)", side: "right" }, thickness: 12, outlinewidth: 0 },
        hovertemplate: `${hover}<br>%{z:.4f} N<extra>model</extra>`,
      },
      cloud(points.others, ink.dot, "simulated"),
      cloud(points.used, ink.ink, "fitted"),
      thisPoint(now, ink),
    ], planeLayout(ink), CONFIG);
  }

  function drawSpace(now, ink) {
    sayWhere(now);
    if (!solid) {
      drawContours(now, ink);
      return;
    }
    const { fit } = state, { surface, points } = positionOf(fit, now);
    const value = force(fit, fit.moves ? now : { ...now, ...centre });
    const cloud = (some, fill, name) => ({
      type: "scatter3d", mode: "markers", name, showlegend: false,
      x: inUm(some, "h0_m"), y: inUm(some, "hv_m"), z: some.map((each) => each.force_n),
      marker: { size: 4, color: fill, line: { color: ink.ink, width: 1 } },
      hovertemplate: `${hover}<br>%{z:.4f} N<extra>${name}</extra>`,
    });
    const line = (title, limits) => ({
      title: { text: title }, range: limits, color: ink.ink, gridcolor: ink.line,
      backgroundcolor: ink.card, showbackground: false, zeroline: false, showspikes: false,
    });
    const across = ([start, end], size) => (
      { show: true, start, end, size, color: ink.soft, width: 1, highlight: false });
    Plotly.react("space", [
      {
        type: "surface", ...surface, colorscale: "Viridis", showscale: false, opacity: 0.75,
        contours: { x: across(seen.h0, 1), y: across(seen.hv, 0.25), z: { highlight: false } },
        lighting: { ambient: 0.95, diffuse: 0.15, specular: 0.02 },
        hovertemplate: `${hover}<br>%{z:.4f} N<extra>model</extra>`,
      },
      cloud(points.others, ink.dot, "simulated"),
      cloud(points.used, ink.ink, "fitted"),
      {
        type: "scatter3d", mode: "markers", name: "this point", showlegend: false,
        x: [now.h0_m / UM], y: [now.hv_m / UM], z: [Number.isFinite(value) ? value : null],
        marker: { symbol: "diamond", size: 7, color: ink.red, line: { color: ink.card, width: 1 } },
        hovertemplate: `${hover}<br>%{z:.4f} N<extra>this point</extra>`,
      },
    ], {
      font: { ...FONT, size: innerWidth < 500 ? 10 : 12, color: ink.ink }, paper_bgcolor: ink.card,
      margin: { l: 0, r: 0, t: 0, b: 0 }, uirevision: "kept",
      scene: {
        xaxis: line("h₀ (µm)", seen.h0), yaxis: line("hᵥ (µm)", seen.hv), zaxis: line("force (N)"),
        aspectmode: "manual", aspectratio: { x: 1.15, y: 1.15, z: 0.8 },
        camera: { eye: eye(), center: { x: 0, y: 0, z: -0.2 } }, dragmode: "turntable",
      },
    }, CONFIG);
  }

  function drawGain(now, ink) {
    const films = sayModulation(now), x = data.modulation?.frequency_hz || [];
    byId("gain").parentElement.hidden = !films.length;
    if (!films.length) return;
    const line = (pick, name, more) => ({
      type: "scatter", mode: "lines", name, x, y: x.map((_, i) => (films.every((f) => f.gain[i] !== null) ? reach(films, (f) => f.gain[i])[pick] : null)),
      line: { color: ink.blue, width: 2 }, hovertemplate: `%{x:.4~s} Hz: %{y:.3f}<extra>${name}</extra>`, ...more,
    });
    const marks = [reach(films, (f) => f.corner_hz)].map(([x0, x1]) => (
      { type: "rect", x0, x1, yref: "paper", y0: 0, y1: 1, fillcolor: ink.shade, line: { color: ink.shade, width: 2 }, layer: "below" }));
    const { xaxis, yaxis, ...layout } = planeLayout(ink);
    Plotly.react("gain", [line(0, "least"), line(1, "largest", { fill: "tonexty" })], {
      ...layout, showlegend: false, shapes: marks,
      xaxis: { ...xaxis, type: "log", dtick: 1, title: { text: "frequency (Hz)", standoff: 8 }, range: null, autorange: true },
      yaxis: { ...yaxis, title: { text: "gain", standoff: 8 }, range: [0, 1.1 * Math.max(...films.flatMap((f) => f.gain))] },
    }, CONFIG);
  }

  function sayWhere(now) {
    const { fit } = state, { points } = positionOf(fit, now);
    byId("at").textContent = fit.moves && points.at && points.at.phi_r_m > 0
      ? ` at the nearest simulated place (${placeOf(points.at)})`
      : "";
  }

  byId("turn").value = view.azimuth;
  byId("turn").addEventListener("input", () => {
    view.azimuth = Number(byId("turn").value);
    Plotly.relayout("space", { "scene.camera.eye": eye() });
  });

  byId("modulated").hidden = !data.modulation;
  for (const [name, reason] of Object.entries(data.not_available)) {
    byId("not-available").append(`Not here: ${name}, for ${reason}. `);
  }
  showFactors();
  update();
  // After the first drawing: what the mouse does to the view moves the slider too.
  requestAnimationFrame(() => requestAnimationFrame(() => {
    byId("js-plotly-tester")?.setAttribute("aria-hidden", "true");
    byId("space").on("plotly_relayout", (change) => {
      const camera = change["scene.camera"]; // of drawings in space alone
      if (!camera) return;
      view.azimuth = (Math.atan2(camera.eye.y, camera.eye.x) * 180) / Math.PI;
      view.distance = Math.hypot(camera.eye.x, camera.eye.y);
      view.height = camera.eye.z;
      byId("turn").value = view.azimuth;
    });
  }));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawSoon);
})();
