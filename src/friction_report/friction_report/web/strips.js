// Rows of coloured codes over time, such as states and reasons.

const ROW = 17;

function stripPanel(panel, box, width, notes) {
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
  const readout = add(notes, "p", undefined, { class: "readout" });
  addKeys(notes, all);
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
  const view = { panned: false };
  const options = timeOptions(width, height(), {
    series: [{}, { show: true, width: 0, points: { show: false } }], axes, legend: { show: false },
    hooks: { draw: [draw], setSelect: [zoomBySelection(view)], setCursor: [tell] }, padding: [0, null, null, null],
  });
  options.scales.y = { range: () => [0, 1] };
  const plot = new uPlot(options, [full, [0, 0]], box);
  const shownStrips = () => rows.flatMap(({ strip }) => strip ?? []);
  return overTime(plot, Object.assign(view, {
    onVisible: () => { layOut(); plot.setSize({ width: plot.width, height: height() }); },
    table: () => stripTable(shownStrips()),
    keys: () => keysOf(all).flatMap(({ groups, meanings }) => [{ label: `${groups.join(", ")}:` },
      ...meanings.map((meaning) => ({ label: meaning.text, colour: colour(meaning.tone), filled: true }))]),
    numbers: () => ({
      headings: ["of", "at the picked time"],
      rows: shownStrips().map((strip) => ({ label: `${strip.group}, ${strip.of}`, cells: [meaningAt(strip, state.picked)?.text ?? "no message"] })),
    }),
    values: () => shownStrips().map((strip) => `${strip.group} ${strip.of} ${meaningAt(strip, state.picked)?.text ?? "no message"}`).join("; "),
  }));
}

/** Each stretch of a strip in the time that is shown, as a row of a table. */
function stripTable(strips) {
  const rows = [], [from, to] = state.shown;
  for (const strip of strips) {
    const time = times[strip.t];
    for (let i = Math.max(lastNotAfter(time, from), 0); i < strip.c.length && time[i] <= to; i++)
      rows.push([strip.group, strip.of, Math.max(time[i], from).toFixed(4), Math.min(time[i + 1], to).toFixed(4), drive.meanings[strip.c[i]]?.text ?? ""]);
  }
  return { headings: ["of", "wheel", "from [s]", "to [s]", "meaning"], rows };
}

/** What the colours of each group stand for; groups with the same colours are one. */
function keysOf(strips) {
  const used = new Set(strips.flatMap((strip) => strip.c)), keys = new Map();
  for (const group of new Set(strips.map((strip) => strip.group))) {
    const meanings = drive.meanings.filter((meaning, i) => used.has(i) && meaning.group === group)
      .sort((a, b) => (b.tone === "good") - (a.tone === "good"));
    const same = meanings.map((meaning) => meaning.text).sort().join();
    keys.set(same, { groups: [...(keys.get(same)?.groups ?? []), group], meanings });
  }
  return [...keys.values()];
}

function addKeys(box, strips) {
  for (const { groups, meanings } of keysOf(strips)) {
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
