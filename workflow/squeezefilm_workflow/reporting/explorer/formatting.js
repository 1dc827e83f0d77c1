"use strict";
// Numbers in words, as the page says them.

// Units of lengths that are shown, in metres.
const UM = 1e-6, MM = 1e-3;

const WORDS = {
  h0_m: "the gap", hv_m: "the amplitude", epsilon: "hᵥ/h₀", phi_r_m: "the distance",
  phi_deg: "the angle", x_m: "x", y_m: "y",
};
const UNITS = {
  h0_m: [UM, "µm"], hv_m: [UM, "µm"], phi_r_m: [MM, "mm"], phi_deg: [1, "°"], epsilon: [1, ""],
  x_m: [MM, "mm"], y_m: [MM, "mm"],
};

function range(limits, name) {
  const [unit, symbol] = UNITS[name];
  return `${limits.map((value) => plain(value / unit)).join("–")} ${symbol}`.trim();
}

function plain(value, digits = 4) {
  return String(Number(value.toPrecision(digits))).replace("-", "−");
}

function percent(share) {
  const value = 100 * share;
  const text = Math.abs(value) >= 100 ? value.toFixed(0) : value.toFixed(2);
  if (Number(text) === 0) return "0.00 %";
  return `${value > 0 ? "+" : ""}${text.replace("-", "−")} %`;
}

// A value up to the last digit of its error, and the error, rounded up to two digits; three digits
// where the error is not known: as squeezefilm.units.to_its_error.
function toItsError(value, error) {
  if (!(error > 0)) return [plain(value, 3), ""];
  const digit = 10 ** (Math.floor(Math.log10(error)) - 1);
  const size = Number((Math.ceil(error / digit - 1e-6) * digit).toPrecision(2));
  const places = 1 - Math.floor(Math.log10(size));
  const shown = size >= 1e-4 ? size.toFixed(Math.max(places, 0)) : size.toExponential(1);
  if (places < 0) return [plain(Math.round(value / 10 ** -places) * 10 ** -places, 15), shown];
  return [value.toFixed(Math.min(places, 9)).replace("-", "−"), shown];
}

// A bound, rounded up to two digits.
function share(value) {
  const digit = 10 ** Math.floor(Math.log10(100 * value) - 1);
  return `${plain(Math.ceil((100 * value) / digit - 1e-9) * digit)} %`;
}
