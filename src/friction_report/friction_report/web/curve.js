// The friction curve at the picked time over slip, and the friction that was measured in the time that is shown.

const valueAt = (curve, name, i) => {
  const value = curve[name].v[i];
  return value === null ? null : value / curve[name].unit;
};
const CURVE_NAMES = ["theta_1", "theta_2", "theta_3", "lambda_max", "mu_max", "lambda_max_stddev", "mu_max_stddev"];

/** The curve of one wheel in force at a time: its parameters, or null. */
function curveAt(curve, time) {
  const i = lastNotAfter(times[curve.t], time);
  if (i < 0) return null;
  const values = { label: curve.label, of: curve.of, kind: curve.kind, age: time - times[curve.t][i] };
  for (const name of CURVE_NAMES) values[name] = valueAt(curve, name, i);
  return values;
}

const burckhardt = (c, slip) => c.theta_1 * (1 - Math.exp(-c.theta_2 * slip)) - c.theta_3 * slip;

/** Lower and upper end of the curves whose peak lies in the 95 % interval of the fitted one. */
function bandAt(c, slip) {
  const across = (INTERVAL_95 * (c.lambda_max_stddev ?? 0)) / c.lambda_max, up = (INTERVAL_95 * (c.mu_max_stddev ?? 0)) / c.mu_max;
  let low = Infinity, high = -Infinity;
  for (const a of [-1, -0.5, 0, 0.5, 1]) {
    const value = burckhardt(c, slip / Math.max(1 + a * across, 0.05));
    low = Math.min(low, value * (1 - up));
    high = Math.max(high, value * (1 + up));
  }
  return [low, high];
}

function slipAt(of, time) {
  const line = drive.lines.find((each) => each.panel === "slip" && each.of === of && each.kind === "estimate");
  if (!line) return null;
  const i = lastNotAfter(times[line.t], time);
  return i < 0 || line.v[i] === null || time - times[line.t][i] > 0.2 ? null : line.v[i] / line.unit;
}

/** Present slips of the wheels that a curve speaks of. */
const slipsOn = (c) => (c.of === "vehicle" ? drive.wheels.filter((of) => !state.hidden.has(of)) : [c.of])
  .map((of) => [of, slipAt(of, state.picked)]).filter(([, slip]) => slip !== null && slip >= 0);

/** Slips and frictions measured in the time that is shown, of what is visible, with the interval of the friction. */
function measuredPoints() {
  const [from, to] = state.shown;
  return drive.points.filter(visible).map((points) => {
    const time = times[points.t], found = [];
    for (let i = firstFrom(time, from); i < time.length && time[i] <= to; i++)
      if (points.slip.v[i] !== null && points.mu.v[i] !== null)
        found.push([points.slip.v[i] / points.slip.unit, points.mu.v[i] / points.mu.unit]);
    return { ...points, found };
  });
}

function drawPoints(plot, measured) {
  const { ctx } = plot, ratio = devicePixelRatio;
  for (const points of measured) {
    ctx.fillStyle = ctx.strokeStyle = colourOf(points);
    ctx.globalAlpha = points.kind === "truth" ? 0.35 : 0.7;
    for (const [slip, mu] of points.found) {
      const x = plot.valToPos(slip, "x", true), y = plot.valToPos(mu, "y", true), size = points.kind === "truth" ? 1 : 3;
      if (points.of === "vehicle") ctx.strokeRect(x - size * ratio, y - size * ratio, 2 * size * ratio, 2 * size * ratio);
      else ctx.fillRect(x - size * ratio, y - size * ratio, 2 * size * ratio, 2 * size * ratio);
    }
  }
  ctx.globalAlpha = 1;
}

function drawPeaks(plot, found) {
  const { ctx } = plot, ratio = devicePixelRatio;
  ctx.lineWidth = 1.5 * ratio;
  const x = (slip) => plot.valToPos(slip, "x", true), y = (mu) => plot.valToPos(mu, "y", true);
  for (const c of found) {
    if (c.kind === "truth" || c.lambda_max === null || c.mu_max === null) continue;
    const dx = INTERVAL_95 * (c.lambda_max_stddev ?? 0), dy = INTERVAL_95 * (c.mu_max_stddev ?? 0);
    ctx.strokeStyle = ctx.fillStyle = colour(colourName(c.of));
    ctx.beginPath();
    ctx.moveTo(x(c.lambda_max - dx), y(c.mu_max)); ctx.lineTo(x(c.lambda_max + dx), y(c.mu_max));
    ctx.moveTo(x(c.lambda_max), y(c.mu_max - dy)); ctx.lineTo(x(c.lambda_max), y(c.mu_max + dy));
    ctx.stroke();
    ctx.fillRect(x(c.lambda_max) - 3 * ratio, y(c.mu_max) - 3 * ratio, 6 * ratio, 6 * ratio);
    for (const [of, slip] of c.theta_1 === null ? [] : slipsOn(c)) {
      ctx.beginPath();
      ctx.arc(x(slip), y(burckhardt(c, slip)), 5 * ratio, 0, 7);
      ctx.strokeStyle = colour(colourName(of));
      ctx.fillStyle = colour("page");
      ctx.fill();
      ctx.stroke();
    }
  }
}

/** Draw inside the axes only. */
const inAxes = (drawIt) => (plot) => {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  drawIt(plot);
  ctx.restore();
};

function curvePanel(panel, box, width, notes) {
  const told = add(notes, "div", undefined, { class: "key" });
  const kinds = new Map(drive.points.map((points) => [points.kind, points.about]));
  if (kinds.size) add(notes, "p", `In the time that is shown: ${[...kinds.values()].join("; ")}`, { class: "remark" });
  let found = [], measured = [], slips = [], plot = null, shownX = null;
  const view = zoomableY({ panned: false }, (low, high) => {
    const peaks = found.map((c) => c.mu_max ?? 0), dots = measured.flatMap((points) => (points.kind === "truth" ? [] : points.found.map(([, mu]) => mu)));
    return [Math.min(0, low), ([high ?? 0, ...peaks, ...dots].reduce((a, b) => Math.max(a, b)) || 1) * 1.06];
  });
  const curves = () => found.filter((c) => c.theta_1 !== null);
  const named = (c) => (c.kind === "truth" ? `${c.label}, true` : c.label);
  const make = () => {
    const series = [{ label: "slip", value: (_, v) => number(v, 3) }], bands = [];
    const peak = Math.max(0.05, ...found.map((c) => c.lambda_max ?? 0));
    const reach = Math.min(1, Math.max(3 * peak, ...found.flatMap(slipsOn).map(([, slip]) => slip)));
    slips = Array.from({ length: 201 }, (_, i) => (i / 200) * reach);
    const data = [slips];
    for (const c of curves()) {
      const truth = c.kind === "truth";
      const shared = { stroke: colour(colourName(c.of)), points: { show: false }, value: (_, v) => number(v, 3) };
      data.push(slips.map((s) => burckhardt(c, s)));
      series.push({ ...shared, label: named(c), dash: truth ? DASHES.truth : [], width: truth ? 1 : 2 });
      if (truth) continue;
      const band = slips.map((s) => bandAt(c, s));
      data.push(band.map((each) => each[0]), band.map((each) => each[1]));
      for (let i = 0; i < 2; i++) series.push({ ...shared, width: 0, class: "edge", label: "" });
      bands.push({ series: [series.length - 1, series.length - 2], fill: `${colour(colourName(c.of))}30` });
    }
    plot?.destroy();
    plot = new uPlot({
      width: Math.min(box.clientWidth || width, 720), height: plotHeight() + 40, series, bands,
      scales: { x: { time: false, range: () => shownX ?? [0, reach] }, y: { range: view.range } },
      axes: [axis({ size: 26, label: "slip λ [-]", gap: 2, labelGap: 0 }), axis({ size: gutter() - 16, label: "friction µ [-]", gap: 2 })],
      cursor: { drag: { x: true, y: true, uni: 12, setScale: false }, bind: { ...bind, dblclick: () => () => { shownX = null; view.setY(null); } } },
      hooks: { drawAxes: [inAxes((u) => drawPoints(u, measured))], draw: [inAxes((u) => drawPeaks(u, found))], setSelect: [zoomBySelection(view)] },
    }, data, box);
  };
  const update = () => {
    found = drive.curves.filter(visible).map((curve) => curveAt(curve, state.picked)).filter(Boolean);
    measured = measuredPoints();
    told.replaceChildren();
    for (const c of found) if (c.kind !== "truth") add(told, "span", tellCurve(c));
    if (!told.childElementCount) add(told, "span", `no valid curve up to ${state.picked.toFixed(3)} s`);
    make();
  };
  update();
  const clearZoom = view.setY;
  return Object.assign(view, {
    plot: () => plot, destroy: () => plot.destroy(), onPick: update, onVisible: update, pickedShare: () => 0.5,
    x: () => [plot.scales.x.min, plot.scales.x.max],
    setX: (low, high) => { shownX = [low, high]; plot.redraw(); },
    setY: (range) => { if (range === null) shownX = null; clearZoom(range); },
    table: () => curveTable(curves(), measured, slips, named),
    keys: () => [...curves().map((c) => ({ label: named(c), colour: colour(colourName(c.of)), dash: c.kind === "truth" ? DASHES.truth : undefined })),
      ...measured.map((points) => ({ label: points.label, colour: colourOf(points), filled: points.of !== "vehicle", hollow: points.of === "vehicle" }))],
    numbers: () => ({
      headings: ["curve", "µ_max with 95 % interval", "λ_max with 95 % interval"],
      rows: found.map((c) => ({ label: named(c), cells: [interval(c, "mu_max"), interval(c, "lambda_max")] })),
    }),
    values: () => found.filter((c) => c.kind !== "truth").map(tellCurve).join("; "),
  });
}

/** Curves with their bands over slip, then the measured points, as rows of a table. */
function curveTable(curves, measured, slips, named) {
  const headings = ["slip [-]"], columns = [];
  for (const c of curves) {
    headings.push(`${named(c)} [-]`);
    columns.push((s) => burckhardt(c, s).toFixed(5));
    if (c.kind === "truth") continue;
    headings.push(`${named(c)}, lower 95 % [-]`, `${named(c)}, upper 95 % [-]`);
    columns.push((s) => bandAt(c, s)[0].toFixed(5), (s) => bandAt(c, s)[1].toFixed(5));
  }
  headings.push(...measured.map((points) => `${points.label} [-]`));
  const rows = slips.map((s) => [s.toFixed(5), ...columns.map((column) => column(s)), ...measured.map(() => "")]);
  measured.forEach((points, place) => {
    for (const [slip, mu] of points.found)
      rows.push([slip, ...columns.map(() => ""), ...measured.map((_, i) => (i === place ? mu : ""))]);
  });
  return { headings, rows };
}

const interval = (c, name) => `${number(c[name], 3)}${c[`${name}_stddev`] === null ? "" : ` ± ${number(INTERVAL_95 * c[`${name}_stddev`], 3)}`}`;

function tellCurve(c) {
  const age = c.age > 0.05 ? `, valid until ${c.age.toFixed(1)} s before` : "";
  const shape = c.theta_1 === null ? "; of the curve only the peak is known" : "";
  return `${c.label}: µ_max ${interval(c, "mu_max")}, λ_max ${interval(c, "lambda_max")} (95 % intervals)${age}${shape}`;
}
