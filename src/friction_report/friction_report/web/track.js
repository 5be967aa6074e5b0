// The track of the car, seen from above, coloured by the friction of its road.

const CLASSES = [0.1, 0.2, 0.4, 0.6, 0.8];  // borders between the colours: ice, snow, wet, dry
const SHADES = ["#cc3311", "#ee7733", "#ddaa33", "#33bbee", "#0077bb", "#5566cc"];  // told apart by every eye, on light and dark

const shadeOf = (mu) => (mu === null ? colour("none") : SHADES[lastNotAfter(CLASSES, mu) + 1]);
const classText = (i) => (i ? (i < CLASSES.length ? `${CLASSES[i - 1]} to ${CLASSES[i]}` : `above ${CLASSES[i - 1]}`) : `below ${CLASSES[0]}`);

function trackPanel(panel, box, width, notes) {
  const { track } = drive, time = times[track.t];
  const [east, north, mu] = ["east", "north", panel.key].map((name) => decoded(track[name].v, track[name].unit));
  const middle = (values) => (Math.min(...values) + Math.max(...values)) / 2;
  const reach = (values) => Math.max(...values) - Math.min(...values);
  const wide = Math.min(box.clientWidth || width, 720), high = plotHeight() + 110;
  const inner = [wide - gutter() - 10, high - 60];  // without axes
  const perPixel = 1.1 * Math.max(reach(east) / inner[0], reach(north) / inner[1], 0.05);
  const whole = [[east, inner[0]], [north, inner[1]]].map(([values, pixels]) => [-1, 1].map((sign) => middle(values) + sign * perPixel * pixels / 2));
  const view = { panned: false };
  let shownX = whole[0], shownY = whole[1];
  const shownRows = () => {
    const first = firstFrom(time, state.shown[0]), rows = [];
    for (let i = first; i < time.length && time[i] <= state.shown[1]; i++) rows.push(i);
    return rows;
  };
  const draw = (plot) => {
    const { ctx } = plot, ratio = devicePixelRatio, size = 5 * ratio;
    const x = (i) => plot.valToPos(east[i], "x", true), y = (i) => plot.valToPos(north[i], "y", true);
    ctx.save();
    ctx.beginPath();
    ctx.rect(plot.bbox.left, plot.bbox.top, plot.bbox.width, plot.bbox.height);
    ctx.clip();
    for (const i of shownRows()) {
      ctx.fillStyle = shadeOf(mu[i]);
      ctx.fillRect(x(i) - size / 2, y(i) - size / 2, size, size);
    }
    const i = lastNotAfter(time, state.picked);
    if (i >= 0) {
      ctx.beginPath();
      ctx.arc(x(i), y(i), 7 * ratio, 0, 7);
      ctx.lineWidth = 2 * ratio;
      ctx.strokeStyle = colour("ink");
      ctx.stroke();
    }
    ctx.restore();
  };
  const told = add(notes, "p", undefined, { class: "readout" });
  const key = add(notes, "div", undefined, { class: "key" });
  add(key, "b", panel.axis);
  SHADES.forEach((shade, i) => {
    const entry = add(key, "span");
    add(entry, "i").style.background = shade;
    entry.append(classText(i));
  });
  const tell = () => {
    const i = lastNotAfter(time, state.picked);
    return i < 0 ? "no place" : `${panel.axis} ${number(mu[i], 3)} at ${east[i].toFixed(0)} m east, ${north[i].toFixed(0)} m north`;
  };
  const plot = new uPlot({
    width: wide, height: high, legend: { show: false },
    scales: { x: { time: false, range: () => shownX }, y: { range: () => shownY } },
    series: [{}, { show: true, width: 0, points: { show: false } }],
    axes: [axis({ size: 26, label: "east of the first fix [m]", gap: 2, labelGap: 0 }), axis({ size: gutter() - 16, label: "north [m]", gap: 2 })],
    cursor: { drag: { x: true, y: true, uni: 12, setScale: false }, bind: { ...bind, dblclick: () => () => { [shownX, shownY] = whole; plot.redraw(); } } },
    hooks: { draw: [draw], setSelect: [zoomBySelection(view)] },
  }, [whole[0], [null, null]], box);
  const update = () => { told.textContent = `${state.picked.toFixed(3)} s: ${tell()}`; plot.redraw(); };
  plot.over.addEventListener("click", () => {
    if (view.panned || plot.select.width >= 3 || !shownRows().length) return;
    const at = [plot.posToVal(plot.cursor.left, "x"), plot.posToVal(plot.cursor.top, "y")];
    const far = (i) => Math.hypot(east[i] - at[0], north[i] - at[1]);
    pick(time[shownRows().reduce((best, i) => (far(i) < far(best) ? i : best))]);
  });
  Object.assign(view, {
    plot: () => plot, destroy: () => plot.destroy(), onPick: update, onShow: update, pickedShare: () => 0.5,
    x: () => shownX, setX: (low, top) => { shownX = [low, top]; plot.redraw(); },
    y: () => shownY, isYZoomed: () => true, setY: (range) => { shownY = range ?? whole[1]; if (range === null) shownX = whole[0]; plot.redraw(); },
    table: () => ({
      headings: ["time since the first sample [s]", "east [m]", "north [m]", `${panel.axis} [-]`],
      rows: shownRows().map((i) => [time[i].toFixed(4), east[i], north[i], mu[i] ?? ""]),
    }),
    keys: () => SHADES.map((shade, i) => ({ label: classText(i), colour: shade, filled: true })),
    numbers: () => ({ headings: ["at the picked time", panel.axis], rows: [{ label: tell(), cells: [number(mu[lastNotAfter(time, state.picked)], 3)] }] }),
    values: tell,
  });
  update();
  return view;
}
