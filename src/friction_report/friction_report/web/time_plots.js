// Plots of lines over time.

const onPaper = () => document.documentElement.classList.contains("paper");
const plotHeight = () => (onPaper() ? 200 : innerWidth < 600 ? 220 : 250);
const gutter = () => (innerWidth < 600 && !onPaper() ? 70 : 84);
const colourOf = (line) => colour(line.colour ?? colourName(line.of));

function axis(more) {
  const grid = { stroke: colour("rule"), width: 1 };
  return { stroke: colour("soft"), grid, ticks: grid, font: theme.font, labelFont: theme.font, labelSize: 16, ...more };
}

/** Mouse presses that begin a selection: those that pan belong to `listen`. */
const bind = {
  mousedown: (_, __, handler) => (event) => (pans(event) ? null : handler(event)),
  dblclick: () => () => { zoom("all"); },
};

/** Options that all plots over time share: one time axis, one cursor, drag to zoom, click to pick. */
function timeOptions(width, height, more) {
  return {
    width, height,
    scales: { x: { time: false, range: () => state.shown } },
    cursor: {
      x: true, y: false,
      drag: { x: true, y: false, setScale: false, ...more.drag },
      sync: { key: "time", filters: { pub: (type) => type === "mousemove" || type === "mouseleave" } },
      hover: { skip: [undefined] },  // not null: where the nearest sample is a gap, there is no value
      bind,
    },
    ...more,
  };
}

/** What all plots over time can do; `view` has the rest. */
function overTime(plot, view) {
  const mark = add(plot.over, "div", undefined, { class: "picked" });
  Object.assign(view, {
    plot: () => plot, x: () => state.shown, setX: show, destroy: () => plot.destroy(),
    pickedShare: () => (state.picked - state.shown[0]) / (state.shown[1] - state.shown[0]),
    onShow: () => plot.setScale("x", { min: state.shown[0], max: state.shown[1] }),
    onPick: () => {
      const left = plot.valToPos(state.picked, "x");
      mark.style.left = `${left - 1}px`;
      mark.hidden = !(left >= -1 && left <= plot.over.clientWidth + 1);
    },
  });
  plot.over.addEventListener("click", () => {
    if (!view.panned && !(plot.select.width >= 3)) pick(plot.posToVal(plot.cursor.left, "x"));
  });
  view.onPick();
  return view;
}

/** Hook that shows what was selected by a drag: a stretch of time, of values, or both. */
const zoomBySelection = (view) => (plot) => {
  const { left, top, width, height } = plot.select;
  if (width < 3 && height < 3) return;
  setTimeout(() => plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false));
  if (view.setY && height >= 3 && height < plot.over.clientHeight)
    view.setY([plot.posToVal(top + height, "y"), plot.posToVal(top, "y")]);
  if (width >= 3 && width < plot.over.clientWidth) view.setX(plot.posToVal(left, "x"), plot.posToVal(left + width, "x"));
};

/** Let a view keep values that are zoomed; `auto` gives the range of those that are not. */
function zoomableY(view, auto) {
  let shown = null;
  view.range = (_, low, high) => shown ?? auto(low, high);
  view.y = () => { const { min, max } = view.plot().scales.y; return [min, max]; };
  view.isYZoomed = () => shown !== null;
  view.setY = (range) => { shown = range; view.plot().redraw(); };
  return view;
}

/** How a line is drawn; on paper and small screens the legend leaves out what is dashed beside `main` lines. */
function seriesOf(line, digits, main) {
  const points = line.kind === "points", noisy = line.kind === "sensor" && line.of === "vehicle";
  const stroke = noisy ? colour("soft") : colourOf(line);
  return {
    label: line.label, stroke, show: visible(line) && !line.off, dash: DASHES[line.kind], class: DASHES[line.kind] && line.kind !== main ? "more" : undefined,
    width: points || noisy ? 0.5 : line.kind === "truth" ? 1 : 1.5,
    points: points ? { show: (_, __, from, to) => to - from < MOST_DOTS, size: 5, fill: stroke } : { show: false },
    value: (_, value) => number(value, digits),
  };
}

/** The lines of a panel with their values on one time axis, bands behind the line they belong to. */
function joinedColumns(lines) {
  const tables = new Map();
  for (const line of lines) {
    if (!tables.has(line.t)) tables.set(line.t, { columns: [times[line.t]], owners: [] });
    const table = tables.get(line.t);
    for (const values of [line.v, ...(line.band ?? [])]) {
      table.columns.push(decoded(values, line.unit));
      table.owners.push(line);
    }
  }
  const parts = [...tables.values()];
  const data = parts.length > 1 ? uPlot.join(parts.map((part) => part.columns)) : parts[0].columns;
  const columns = parts.flatMap((part) => part.owners).map((line, i) => ({ line, values: data[i + 1] }));
  columns.sort((a, b) => lines.indexOf(a.line) - lines.indexOf(b.line));
  return { time: data[0], columns };
}

/** Decimals of a line's values. */
const digitsOf = (line) => Math.round(Math.log10(line.unit));

const linesOf = (panel) => panel.lines ?? drive.lines.filter((line) => line.panel === panel.key);

function linePanel(panel, box, width, notes) {
  const lines = linesOf(panel).sort((a, b) => KINDS.indexOf(a.kind) - KINDS.indexOf(b.kind));
  const { time, columns } = joinedColumns(lines);
  const series = [{ label: "t [s]", value: (_, t) => number(t, 3) }], bands = [];
  columns.forEach(({ line }, i) => {
    const edge = i > 0 && columns[i - 1].line === line;
    series.push(edge
      ? { ...seriesOf(line, digitsOf(line), null), width: 0, points: { show: false }, class: "edge", label: "" } : seriesOf(line, digitsOf(line), lines[0].kind));
    if (edge && columns[i - 2]?.line === line)
      bands.push({ series: [i + 1, i], fill: `${colourOf(line)}30` });
  });
  const axes = [
    axis({ size: 26, label: "time since the first sample [s]", gap: 2, labelGap: 0 }),
    axis({ size: gutter() - 16, label: panel.axis, gap: 2 }),
  ];
  const view = zoomableY({ panned: false }, (low, high) => (low === null ? [0, 1] : uPlot.rangeNum(low, high, 0.08, true)));
  const refresh = () => columns.forEach(({ line }, i) => {
    const there = visible(line) && !line.off;
    if (plot.series[i + 1].show !== there) plot.setSeries(i + 1, { show: there });
  });
  const switched = (_, i, { show }) => {  // a click on the legend hides the band as well
    if (show === undefined || !i || columns[i - 1].line.off === !show || !visible(columns[i - 1].line)) return;
    columns[i - 1].line.off = !show;
    refresh();
  };
  const options = timeOptions(width, plotHeight(), {
    series, bands, axes, drag: { y: true, uni: 12 },
    hooks: { setSelect: [zoomBySelection(view)], setSeries: [switched] },
    legend: { markers: { dash: (_, i) => BORDERS[columns[i - 1]?.line.kind] ?? "solid" } },
  });
  options.scales.y = { range: view.range };
  const plot = new uPlot(options, [time, ...columns.map((column) => column.values)], box);
  const dashed = KINDS.filter((kind) => DASH_TEXTS[kind] && lines.some((line) => line.kind === kind));
  const told = [...dashed.map((kind) => DASH_TEXTS[kind]), ...(bands.length ? ["bands: 95 % intervals"] : [])];
  if (told.length) add(notes, "p", told.join("; "), { class: "remark" });
  const shownLines = () => lines.filter((line) => visible(line) && !line.off);
  return overTime(plot, Object.assign(view, {
    onVisible: refresh,
    table: () => lineTable(panel, shownLines()),
    keys: () => shownLines().map((line) => ({ label: line.label, colour: colourOf(line), dash: DASHES[line.kind] })),
    numbers: () => ({
      headings: ["line", "at the picked time", "95 % interval", "least shown", "greatest shown"],
      rows: lines.filter(visible).map((line) => ({ label: line.label, line, cells: statistics(line), flip: () => { line.off = !line.off; refresh(); } })),
    }),
    values: () => shownLines().map((line) => [line.label, at(line, state.picked)]).filter(([, found]) => found)
      .map(([label, found]) => `${label} ${found.text}`).join("; "),
  }));
}

/** Heading of a line's numbers in a table, with the unit of the panel's axis. */
const headingOf = (panel, line) => `${line.label} ${(line.axis ?? panel.axis).match(/\[.*\]/)?.[0] ?? ""}`.trim();

/** The visible lines in the time that is shown, as rows of a table. */
function lineTable(panel, lines) {
  const headings = ["time since the first sample [s]"];
  if (!lines.length) return { headings, rows: [] };
  const { time, columns } = joinedColumns(lines), seen = new Map();
  for (const { line } of columns) {
    const n = seen.get(line) ?? 0;
    seen.set(line, n + 1);
    headings.push(headingOf(panel, line) + ["", ", lower 95 %", ", upper 95 %"][n]);
  }
  const rows = [];
  for (let i = firstFrom(time, state.shown[0]); i < time.length && time[i] <= state.shown[1]; i++) {
    const cells = columns.map(({ values }) => values[i] ?? "");
    if (cells.some((cell) => cell !== "")) rows.push([time[i].toFixed(4), ...cells]);
  }
  return { headings, rows };
}

/** The last value of a line up to a time with its interval as text, null where there is none. */
function at(line, time) {
  const i = lastNotAfter(times[line.t], time), digits = digitsOf(line);
  if (i < 0 || line.v[i] === null || (i === line.v.length - 1 && time > times[line.t][i] + 1e-4)) return null;
  const text = (v) => number(v / line.unit, digits);
  const band = line.band && line.band[0][i] !== null ? `${text(line.band[0][i])} to ${text(line.band[1][i])}` : "";
  return { value: text(line.v[i]), band, text: text(line.v[i]) + (band ? ` (95 %: ${band})` : "") };
}

/** Value and interval of a line at the picked time; the least and the greatest value of the time that is shown. */
function statistics(line) {
  const found = at(line, state.picked), time = times[line.t], digits = digitsOf(line);
  let least = Infinity, greatest = -Infinity;
  for (let i = firstFrom(time, state.shown[0]); i < time.length && time[i] <= state.shown[1]; i++) {
    if (line.v[i] === null) continue;
    least = Math.min(least, line.v[i]);
    greatest = Math.max(greatest, line.v[i]);
  }
  const text = (value) => (Number.isFinite(value) ? number(value / line.unit, digits) : "–");
  return [found?.value ?? "–", found?.band || "–", text(least), text(greatest)];
}
