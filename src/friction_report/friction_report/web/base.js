// State of the page, its data decoded, and small helpers. All files of the page share the scope of one function.

const drive = JSON.parse(document.getElementById("drive").textContent);
const [begin, end] = drive.span;
const full = end > begin ? [begin, end] : [begin - 0.5, begin + 0.5];
const lastBraking = drive.brakings[drive.brakings.length - 1];
const state = {
  shown: full, picked: lastBraking ? (lastBraking.start + lastBraking.end) / 2 : full[1],
  hidden: new Set(), truth: true, drag: "zoom", own: [],
};
const panels = [];  // of the page, in its order: see addPanel
let theme = {};

const find = (selector) => document.querySelector(selector);

function add(parent, tag, text, attributes = {}) {
  const element = document.createElement(tag);
  if (text !== undefined) element.textContent = text;
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  parent.append(element);
  return element;
}

/** Index of the last value that is not greater than x, -1 where there is none. */
function lastNotAfter(values, x) {
  let low = 0, high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] <= x) low = middle + 1; else high = middle;
  }
  return low - 1;
}

/** Index of the first of increasing values that is not less than x. */
const firstFrom = (values, x) => { const i = lastNotAfter(values, x); return i >= 0 && values[i] === x ? i : i + 1; };

const times = drive.times.map((steps) => {
  let ticks = 0;
  return steps.map((step) => (ticks += step) / 1e4);
});
const KINDS = ["sensor", "estimate", "points", "bound", "aim", "demand", "truth"];
const INTERVAL_95 = drive.interval;  // half width of a 95 % interval in standard deviations
const MOST_DOTS = 3000;  // more of them hide each other and take seconds to draw
const DASHES = { truth: [6, 3], bound: [1, 3], aim: [2, 3], demand: [9, 3, 2, 3] };
const DASH_TEXTS = { truth: "dashed: true", bound: "finely dotted: believed bound", aim: "dotted: set-point of the law", demand: "dash-dotted: driver's demand" };
const BORDERS = { truth: "dashed", bound: "dotted", aim: "dotted", demand: "double" };

const decoded = (values, unit) => values.map((value) => (value === null ? null : value / unit));
const number = (value, digits) => (value === null || value === undefined ? "–" : value.toFixed(digits));
const colour = (name) => theme[name];
const colourName = (of) => (drive.wheels.indexOf(of) < 0 || of === "vehicle" || of === "driver"
  ? (of === "driver" ? "driver" : "vehicle") : `wheel${drive.wheels.indexOf(of) % 6}`);
const visible = (each) => !state.hidden.has(each.of) && (state.truth || each.kind !== "truth");

function readTheme() {
  const style = getComputedStyle(document.documentElement);
  theme = {};
  for (const name of ["page", "ink", "soft", "rule", "link", "vehicle", "driver", "good", "middle", "bad", "none"])
    theme[name] = style.getPropertyValue(`--${name}`).trim();
  for (let i = 0; i < 6; i++) theme[`wheel${i}`] = style.getPropertyValue(`--wheel${i}`).trim();
  for (let i = 0; i < 8; i++) theme[`reason${i}`] = style.getPropertyValue(`--reason${i}`).trim();
  theme.font = `11px ${getComputedStyle(document.body).fontFamily}`;
}
