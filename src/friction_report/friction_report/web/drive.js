"use strict";
// Draws the drive that stands as JSON in the page. Everything of the bag is set as text, never as HTML.
(() => {
  const drive = JSON.parse(document.getElementById("drive").textContent);
  const [begin, end] = drive.span;
  const full = end > begin ? [begin, end] : [begin - 0.5, begin + 0.5];
  const last = drive.brakings[drive.brakings.length - 1];
  const state = { shown: full, picked: last ? (last.start + last.end) / 2 : full[1], hidden: new Set(), truth: true };
  const plots = [];
  let theme = {};

  // --- small helpers -------------------------------------------------------------------------------------------------

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

  const times = drive.times.map((steps) => {
    let ticks = 0;
    return steps.map((step) => (ticks += step) / 1e4);
  });
  const KINDS = ["sensor", "estimate", "points", "bound", "aim", "demand", "truth"];
  const INTERVAL_95 = drive.interval;  // half width of a 95 % interval in standard deviations
  const MOST_DOTS = 3000;  // more of them hide each other and take seconds to draw
  const DASHES = { truth: [6, 3], bound: [1, 3], aim: [2, 3], demand: [9, 3, 2, 3] };
  const DASH_TEXTS = { truth: "dashed: true", bound: "finely dotted: believed bound", aim: "dotted: set-point of the law", demand: "dash-dotted: driver's demand" };

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

  // --- the time that is shown, and the one that is picked --------------------------------------------------------------

  function show(from, to) {
    const width = Math.min(Math.max(to - from, 1e-3), full[1] - full[0]);
    const start = Math.min(Math.max(from, full[0]), full[1] - width);
    state.shown = [start, start + width];
    for (const plot of plots) if (plot.overTime) plot.setScale("x", { min: start, max: start + width });
    const slider = find("#pick input");
    [slider.min, slider.max] = state.shown;
    pick(Math.min(Math.max(state.picked, start), start + width));
  }

  function pick(time) {
    state.picked = time;
    find("#pick input").value = time;
    find("#pick output").textContent = `${time.toFixed(3)} s`;
    for (const plot of plots) plot.onPick?.();
  }

  function zoom(how) {
    const [from, to] = state.shown, width = to - from;
    if (how === "all") { chooseRow(null); show(...full); }
    else if (how === "in") show(state.picked - width / 4, state.picked + width / 4);
    else if (how === "out") show(from - width / 2, to + width / 2);
    else show(from + (how === "on" ? 0.5 : -0.5) * width, to + (how === "on" ? 0.5 : -0.5) * width);
  }

  // --- plots over time -------------------------------------------------------------------------------------------------

  const onPaper = () => document.documentElement.classList.contains("paper");
  const plotHeight = () => (onPaper() ? 200 : innerWidth < 600 ? 220 : 250);
  const gutter = () => (innerWidth < 600 && !onPaper() ? 70 : 84);

  function axis(more) {
    const grid = { stroke: colour("rule"), width: 1 };
    return { stroke: colour("soft"), grid, ticks: grid, font: theme.font, labelFont: theme.font, labelSize: 16, ...more };
  }

  /** Options that all plots over time share: one time axis, one cursor, drag to zoom, click to pick. */
  function timeOptions(width, height, more) {
    return {
      width, height,
      scales: { x: { time: false, range: () => state.shown } },
      cursor: {
        x: true, y: false,
        drag: { x: true, y: false, setScale: false },
        sync: { key: "time", filters: { pub: (type) => type === "mousemove" || type === "mouseleave" } },
        hover: { skip: [undefined] },  // not null: where the nearest sample is a gap, there is no value
        bind: { dblclick: () => () => { show(...full); } },
      },
      ...more,
    };
  }

  function overTime(plot) {
    plot.overTime = true;
    const mark = add(plot.over, "div", undefined, { class: "picked" });
    plot.onPick = () => {
      const left = plot.valToPos(state.picked, "x");
      mark.style.left = `${left - 1}px`;
      mark.hidden = !(left >= -1 && left <= plot.over.clientWidth + 1);
    };
    plot.over.addEventListener("click", () => {
      if (plot.select.width < 3) pick(plot.posToVal(plot.cursor.left, "x"));
    });
    plot.onPick();
    return plot;
  }

  const zoomBySelection = (plot) => {
    if (plot.select.width < 3) return;
    const from = plot.posToVal(plot.select.left, "x"), to = plot.posToVal(plot.select.left + plot.select.width, "x");
    setTimeout(() => plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false));
    show(from, to);
  };

  /** How a line is drawn; on paper and small screens the legend leaves out what is dashed beside `main` lines. */
  function seriesOf(line, digits, main) {
    const points = line.kind === "points", noisy = line.kind === "sensor" && line.of === "vehicle";
    const stroke = colour(noisy ? "soft" : colourName(line.of));
    return {
      label: line.label, stroke, show: visible(line), dash: DASHES[line.kind], class: DASHES[line.kind] && line.kind !== main ? "more" : undefined,
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

  function linePanel(panel, box, width) {
    const lines = drive.lines.filter((line) => line.panel === panel.key)
      .sort((a, b) => KINDS.indexOf(a.kind) - KINDS.indexOf(b.kind));
    const digits = Math.round(Math.log10(lines[0].unit));
    const { time, columns } = joinedColumns(lines);
    const series = [{ label: "t [s]", value: (_, t) => number(t, 3) }], bands = [];
    columns.forEach(({ line }, i) => {
      const edge = i > 0 && columns[i - 1].line === line;
      series.push(edge
        ? { ...seriesOf(line, digits, null), width: 0, points: { show: false }, class: "edge", label: "" } : seriesOf(line, digits, lines[0].kind));
      if (edge && columns[i - 2]?.line === line)
        bands.push({ series: [i + 1, i], fill: `${colour(colourName(line.of))}30` });
    });
    const axes = [
      axis({ size: 26, label: "time since the first sample [s]", gap: 2, labelGap: 0 }),
      axis({ size: gutter() - 16, label: panel.axis, gap: 2 }),
    ];
    const options = timeOptions(width, plotHeight(), { series, bands, axes, hooks: { setSelect: [zoomBySelection] } });
    options.scales.y = { range: (_, low, high) => (low === null ? [0, 1] : uPlot.rangeNum(low, high, 0.08, true)) };
    const plot = overTime(new uPlot(options, [time, ...columns.map((column) => column.values)], box));
    const dashed = KINDS.filter((kind) => DASH_TEXTS[kind] && lines.some((line) => line.kind === kind));
    const told = [...dashed.map((kind) => DASH_TEXTS[kind]), ...(bands.length ? ["bands: 95 % intervals"] : [])];
    if (told.length) add(box, "p", told.join("; "), { class: "remark" });
    plot.onVisible = () => columns.forEach(({ line }, i) => {
      if (plot.series[i + 1].show !== visible(line)) plot.setSeries(i + 1, { show: visible(line) });
    });
    return plot;
  }

  // --- strips ----------------------------------------------------------------------------------------------------------

  const ROW = 17;

  function stripPanel(panel, box, width) {
    const all = drive.strips.filter((strip) => strip.panel === panel.key);
    let rows = [];
    const layOut = () => {
      rows = [];
      let group = null;
      for (const strip of all) {
        if (state.hidden.has(strip.of) || (strip.group === "true" && !state.truth)) continue;
        if (strip.group !== group) rows.push({ heading: (group = strip.group) });
        rows.push({ strip });
      }
    };
    layOut();
    const height = () => Math.max(rows.length, 1) * ROW + 26 + 16;
    const draw = (plot) => drawRows(plot, rows);
    const readout = document.createElement("p");
    readout.className = "readout";
    const tell = (plot) => {
      const row = rows[Math.floor(plot.cursor.top / ROW)];
      if (!row?.strip || plot.cursor.left < 0) { readout.textContent = ""; return; }
      const time = plot.posToVal(plot.cursor.left, "x");
      readout.textContent = `${time.toFixed(3)} s, ${row.strip.group}, ${row.strip.of}: ${meaningAt(row.strip, time)?.text ?? "no message"}`;
    };
    const axes = [
      axis({ size: 26, label: "time since the first sample [s]", gap: 2, labelGap: 0 }),
      axis({ size: gutter(), values: () => [], grid: { show: false }, ticks: { show: false } }),
    ];
    const options = timeOptions(width, height(), {
      series: [{}, { show: true, width: 0, points: { show: false } }], axes, legend: { show: false },
      hooks: { draw: [draw], setSelect: [zoomBySelection], setCursor: [tell] }, padding: [0, null, null, null],
    });
    options.scales.y = { range: () => [0, 1] };
    const plot = overTime(new uPlot(options, [full, [0, 0]], box));
    box.append(readout);
    addKeys(box, all);
    plot.onVisible = () => { layOut(); plot.setSize({ width: plot.width, height: height() }); };
    return plot;
  }

  /** What the colours of each group stand for; groups with the same colours share a line. */
  function addKeys(box, strips) {
    const used = new Set(strips.flatMap((strip) => strip.c)), keys = new Map();
    for (const group of new Set(strips.map((strip) => strip.group))) {
      const meanings = drive.meanings.filter((meaning, i) => used.has(i) && meaning.group === group)
        .sort((a, b) => (b.tone === "good") - (a.tone === "good"));
      const same = meanings.map((meaning) => meaning.text).sort().join();
      keys.set(same, { groups: [...(keys.get(same)?.groups ?? []), group], meanings });
    }
    for (const { groups, meanings } of keys.values()) {
      const key = add(box, "div", undefined, { class: "key" });
      add(key, "b", groups.join(", "));
      for (const meaning of meanings) {
        const entry = add(key, "span");
        add(entry, "i").style.background = `var(--${meaning.tone})`;
        entry.append(meaning.text);
      }
    }
  }

  function meaningAt(strip, time) {
    const at = times[strip.t], i = lastNotAfter(at, time);
    return i < 0 || time > at[at.length - 1] ? null : drive.meanings[strip.c[Math.min(i, strip.c.length - 1)]];
  }

  function drawRows(plot, rows) {
    const { ctx, bbox } = plot, ratio = devicePixelRatio, row = ROW * ratio;
    ctx.save();
    ctx.font = theme.font.replace("11px", `${11 * ratio}px`);
    ctx.textBaseline = "middle";
    ctx.textAlign = "left";
    rows.forEach(({ heading, strip }, i) => {
      const top = bbox.top + i * row, middle = top + row / 2;
      if (heading !== undefined) {
        ctx.fillStyle = colour("ink");
        ctx.fillText(heading, 2 * ratio, middle + ratio);
        return;
      }
      ctx.fillStyle = colour(colourName(strip.of));
      ctx.fillText(fitted(ctx, strip.of, bbox.left - 8 * ratio), 2 * ratio, middle);
      drawStrip(plot, strip, top + 1.5 * ratio, row - 3 * ratio);
    });
    ctx.restore();
  }

  function fitted(ctx, text, width) {
    if (ctx.measureText(text).width <= width) return text;
    let kept = text.length;
    while (kept > 1 && ctx.measureText(`${text.slice(0, kept)}…`).width > width) kept--;
    return `${text.slice(0, kept)}…`;
  }

  function drawStrip(plot, strip, top, height) {
    const { ctx, bbox } = plot, at = times[strip.t], right = bbox.left + bbox.width;
    const first = Math.max(lastNotAfter(at, state.shown[0]), 0);
    let painted = -1;
    for (let i = first; i < strip.c.length && at[i] <= state.shown[1]; i++) {
      const meaning = drive.meanings[strip.c[i]];
      if (!meaning) continue;
      const from = Math.max(plot.valToPos(at[i], "x", true), bbox.left);
      const to = Math.min(plot.valToPos(at[i + 1], "x", true), right);
      if (to < painted) continue;  // all of it lies in a pixel that has its colour
      painted = Math.max(to, from + 1);
      ctx.fillStyle = colour(meaning.tone);
      ctx.fillRect(from, top, Math.max(to - from, 1), height);  // what is shorter than a pixel is still seen
    }
  }

  // --- the friction curve at the picked time ---------------------------------------------------------------------------

  const valueAt = (curve, name, i) => {
    const value = curve[name].v[i];
    return value === null ? null : value / curve[name].unit;
  };

  /** The curve of one wheel in force at a time: its parameters, or null. */
  function curveAt(curve, time) {
    const i = lastNotAfter(times[curve.t], time);
    if (i < 0) return null;
    const values = { label: curve.label, of: curve.of, kind: curve.kind, age: time - times[curve.t][i] };
    for (const name of ["theta_1", "theta_2", "theta_3", "lambda_max", "mu_max", "lambda_max_stddev", "mu_max_stddev"])
      values[name] = valueAt(curve, name, i);
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

  function curvePanel(panel, box, width) {
    const told = add(box, "div", undefined, { class: "key" });
    const slips = Array.from({ length: 201 }, (_, i) => i / 200);
    let found = [], plot = null;
    const crosses = (u) => {
      const { ctx, bbox } = u, ratio = devicePixelRatio;
      ctx.save();
      ctx.beginPath();
      ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
      ctx.clip();
      ctx.lineWidth = 1.5 * ratio;
      for (const c of found) {
        if (c.kind === "truth" || c.lambda_max === null || c.mu_max === null) continue;
        const x = (slip) => u.valToPos(slip, "x", true), y = (mu) => u.valToPos(mu, "y", true);
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
      ctx.restore();
    };
    const make = () => {
      const series = [{ label: "slip", value: (_, v) => number(v, 3) }], bands = [], data = [];
      const peak = Math.max(0.05, ...found.map((c) => c.lambda_max ?? 0));
      const reach = Math.min(1, Math.max(3 * peak, ...found.flatMap(slipsOn).map(([, slip]) => slip)));
      data.push(slips.map((s) => s * reach));
      for (const c of found) {
        const whole = c.theta_1 !== null;
        const shared = { stroke: colour(colourName(c.of)), points: { show: false }, value: (_, v) => number(v, 3) };
        data.push(data[0].map((s) => (whole ? burckhardt(c, s) : null)));
        series.push({ ...shared, label: c.kind === "truth" ? `${c.label}, true` : c.label, dash: c.kind === "truth" ? [6, 3] : [], width: c.kind === "truth" ? 1 : 2 });
        if (c.kind === "truth" || !whole) continue;
        const band = data[0].map((s) => bandAt(c, s));
        data.push(band.map((each) => each[0]), band.map((each) => each[1]));
        for (let i = 0; i < 2; i++) series.push({ ...shared, width: 0, class: "edge", label: "" });
        bands.push({ series: [series.length - 1, series.length - 2], fill: `${colour(colourName(c.of))}30` });
      }
      plot?.destroy();
      plot = new uPlot({
        width: Math.min(box.clientWidth || width, 720), height: plotHeight() + 40, series, bands,
        scales: { x: { time: false, range: (_, low, high) => [low, high] }, y: { range: (_, low, high) => [Math.min(0, low), (high || 1) * 1.06] } },
        axes: [axis({ size: 26, label: "slip λ [-]", gap: 2, labelGap: 0 }), axis({ size: gutter() - 16, label: "friction µ [-]", gap: 2 })],
        cursor: { drag: { x: false, y: false } }, hooks: { draw: [crosses] },
      }, data, box);
    };
    const update = () => {
      found = drive.curves.filter(visible).map((curve) => curveAt(curve, state.picked)).filter(Boolean);
      told.replaceChildren();
      for (const c of found) if (c.kind !== "truth") add(told, "span", tellCurve(c));
      if (!told.childElementCount) add(told, "span", `no valid curve up to ${state.picked.toFixed(3)} s`);
      make();
    };
    update();
    return { onPick: update, onVisible: update, setSize: update, destroy: () => plot.destroy() };
  }

  function tellCurve(c) {
    const value = (name, digits) => `${number(c[name], digits)}${c[`${name}_stddev`] === null ? "" : ` ± ${number(INTERVAL_95 * c[`${name}_stddev`], digits)}`}`;
    const age = c.age > 0.05 ? `, valid until ${c.age.toFixed(1)} s before` : "";
    const shape = c.theta_1 === null ? "; the method fits no curve of Burckhardt's form" : "";
    return `${c.label}: µ_max ${value("mu_max", 3)}, λ_max ${value("lambda_max", 3)} (95 % intervals)${age}${shape}`;
  }

  // --- the page --------------------------------------------------------------------------------------------------------

  function build() {
    for (const plot of plots.splice(0)) plot.destroy();
    readTheme();
    const host = find("#panels");
    host.replaceChildren();
    const width = Math.max(host.clientWidth, 240);
    for (const panel of drive.panels) {
      const box = add(host, "section", undefined, { class: "panel", id: `panel_${panel.key}` });
      add(box, "h2", panel.title);
      const makers = { curve: curvePanel, sign: stripPanel, supervisor: stripPanel, validity: stripPanel };
      plots.push((makers[panel.key] ?? linePanel)(panel, box, width));
      if (panel.remarks.length) add(box, "p", panel.remarks.join("; "), { class: "remark" });
    }
    show(...state.shown);
  }

  function chooseRow(row) {
    for (const each of document.querySelectorAll("tr.chosen")) each.classList.remove("chosen");
    row?.classList.add("chosen");
  }

  function headings(table, texts) {
    const row = add(add(table, "thead"), "tr");
    for (const [text, unit, kind] of texts)
      add(add(row, "th", text, kind ? { class: kind, scope: "col" } : { scope: "col" }), "small", unit);
    return add(table, "tbody");
  }

  function fillBrakings() {
    const table = find("#brakings table");
    if (!drive.brakings.length) {
      find("#brakings .hint").textContent = "No braking: the car's speed is not known, or it never falls by 1 m/s with more than 1 m/s².";
      return;
    }
    const body = headings(table, [["start", "[s]"], ["grip used", "largest [-]"], ["µ_max", "last valid [-]"], ["λ_max", "last valid [-]"],
      ["valid", "of the time"], ["speed", "[m/s]"], ["deceleration", "mean / largest [m/s²]"], ["duration", "[s]"], ["largest slip", "above 5 m/s [-]"]]);
    for (const b of drive.brakings) {
      const row = add(body, "tr", undefined, { tabindex: "0" });
      add(row, "td", number(b.start, 2));
      for (const [name, digits] of [["mu_used", 2], ["mu_max", 3], ["lambda_max", 3]]) {
        const cell = add(row, "td");
        for (const part of b.parts) if (part[name][0] !== null || (part.reason && name === "mu_max")) add(cell, "div", valueOf(part, name, digits, b.parts.length > 1));
      }
      const valid = add(row, "td");
      for (const part of b.parts) if (part.valid !== null) add(valid, "div", `${(100 * part.valid).toFixed(0)} %`);
      add(row, "td", `${number(b.from, 1)} – ${number(b.to, 1)}`);
      add(row, "td", `${number(b.deceleration, 1)} / ${number(b.hardest, 1)}`);
      add(row, "td", number(b.end - b.start, 2));
      add(row, "td", b.slip === null ? "–" : `${number(b.slip, 3)} ${b.slip_of}`);
      const choose = () => {
        chooseRow(row);
        const margin = Math.max(0.3, 0.1 * (b.end - b.start));
        state.picked = b.end;
        show(b.start - margin, b.end + margin);
      };
      row.addEventListener("click", choose);
      row.addEventListener("keydown", (event) => { if (event.key === "Enter" || event.key === " ") { event.preventDefault(); choose(); } });
    }
  }

  /** A value with half of its 95 % interval, or the reason why there is none; the part of the car where there are several. */
  const valueOf = (part, name, digits, several) => {
    const [value, reach] = part[name];
    const text = value === null ? part.reason : reach === null ? number(value, digits) : `${number(value, digits)} ± ${number(reach, digits)}`;
    return several ? `${part.of} ${text}` : text;
  };

  function fillTopics() {
    const body = headings(find("#topics table"), [["topic", "", "text"], ["messages", ""], ["valid", ""], ["why not", "most frequent first", "long"]]);
    for (const topic of drive.topics) {
      const row = add(body, "tr");
      add(row, "td", topic.name, { class: "text" });
      add(row, "td", String(topic.messages));
      add(row, "td", topic.valid === null ? "" : `${(100 * topic.valid).toFixed(1)} %`);
      add(row, "td", topic.reasons.join("; "), { class: "long" });
    }
    if (drive.not_drawn.length) find("#not_drawn").textContent = `Not drawn: ${drive.not_drawn.join(", ")}`;
  }

  function fillControls() {
    const box = find("#wheels");
    const toggle = (text, name, flip) => {
      const button = add(box, "button", undefined, { type: "button", "aria-pressed": "true" });
      if (name) add(button, "i").style.background = `var(--${name})`;
      button.append(text);
      button.addEventListener("click", () => {
        button.setAttribute("aria-pressed", String(flip()));
        for (const plot of plots) plot.onVisible?.();
      });
    };
    for (const of of drive.wheels)
      toggle(of === "vehicle" ? "car" : of, colourName(of), () => (state.hidden.delete(of) ? true : (state.hidden.add(of), false)));
    if (drive.lines.some((line) => line.kind === "truth")) toggle("true values", null, () => (state.truth = !state.truth));
    for (const button of document.querySelectorAll("[data-zoom]"))
      button.addEventListener("click", () => zoom(button.dataset.zoom));
    find("#pick input").addEventListener("input", (event) => pick(Number(event.target.value)));
  }

  function fillHeader() {
    for (const [name, text] of drive.facts) {
      if (text) { add(find("#facts"), "dt", name); add(find("#facts"), "dd", text); }
      else add(find("#remarks"), "li", name);
    }
    if (drive.absent.length) add(find("#remarks"), "li", `Not shown: ${drive.absent.join("; ")}`);
    for (const text of drive.problems) add(find("#remarks"), "li", `damaged: ${text}`);
  }

  fillHeader();
  fillBrakings();
  fillControls();
  fillTopics();
  build();
  let width = innerWidth;
  addEventListener("resize", () => { if (innerWidth !== width) { width = innerWidth; build(); } });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", build);
  const setPaper = (paper) => {
    document.documentElement.classList.toggle("paper", paper);
    find("#panels").style.width = paper ? "700px" : "";
    build();
  };
  addEventListener("beforeprint", () => setPaper(true));
  addEventListener("afterprint", () => setPaper(false));
})();
