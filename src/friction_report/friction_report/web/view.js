// The time that is shown and the one that is picked, and how mouse, fingers and keys change what a plot shows.

function show(from, to) {
  const width = Math.min(Math.max(to - from, 1e-3), full[1] - full[0]);
  const start = Math.min(Math.max(from, full[0]), full[1] - width);
  state.shown = [start, start + width];
  for (const view of panels) view.onShow?.();
  const slider = find("#pick input");
  [slider.min, slider.max] = state.shown;
  pick(Math.min(Math.max(state.picked, start), start + width));
}

function pick(time) {
  state.picked = Math.min(Math.max(time, state.shown[0]), state.shown[1]);
  const slider = find("#pick input"), text = `${state.picked.toFixed(3)} s`;
  slider.value = state.picked;
  slider.setAttribute("aria-valuetext", text);
  find("#pick output").textContent = text;
  for (const view of panels) view.onPick?.();
}

function zoom(how) {
  const [from, to] = state.shown, width = to - from;
  if (how === "all") {
    chooseRow(null);
    for (const view of panels) view.setY?.(null);
    show(...full);
  } else if (how === "in") show(state.picked - width / 4, state.picked + width / 4);
  else if (how === "out") show(from - width / 2, to + width / 2);
  else show(from + (how === "on" ? 0.5 : -0.5) * width, to + (how === "on" ? 0.5 : -0.5) * width);
}

const pans = (event) => state.drag === "pan" || event.shiftKey;
const around = ([low, high], share, factor) => {
  const fixed = low + share * (high - low);
  return [fixed - factor * (fixed - low), fixed + factor * (high - fixed)];
};
const moved = ([low, high], share) => [low + share * (high - low), high + share * (high - low)];

/** Zoom about a place of the plot, given as shares of its width and height from the left and the bottom. */
const zoomX = (view, share, factor) => view.setX(...around(view.x(), share, factor));
const zoomY = (view, share, factor) => view.setY?.(around(view.y(), share, factor));

/** Wheel, drag, fingers and keys on the box of a plot; a wheel without Ctrl scrolls the page until the plot has the focus. */
function listen(view, box, signal) {
  const place = (event) => {
    const area = view.plot().over.getBoundingClientRect();
    return { x: (event.clientX - area.left) / area.width, y: 1 - (event.clientY - area.top) / area.height, area };
  };
  box.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey && document.activeElement !== box) return;
    event.preventDefault();
    const at = place(event), turned = event.deltaY || event.deltaX;
    const factor = 2 ** (turned * (event.deltaMode ? 0.06 : 0.002));
    if (event.shiftKey || at.x < 0) zoomY(view, at.y, factor); else zoomX(view, Math.min(at.x, 1), factor);
  }, { passive: false });

  const fingers = new Map();
  box.addEventListener("pointerdown", (event) => {
    if (!event.target.closest(".u-over")) return;
    box.focus({ preventScroll: true });
    view.panned = false;
    if (event.pointerType !== "mouse" || pans(event)) fingers.set(event.pointerId, event);
  });
  addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const [x, y] = [event.clientX - before.clientX, event.clientY - before.clientY];
    if (!view.panned && Math.hypot(x, y) < 3) return;
    view.panned = true;
    const { area } = place(event), other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
    if (other) {
      const apart = (one) => Math.max(Math.abs(one.clientX - other.clientX), 20);
      zoomX(view, ((event.clientX + other.clientX) / 2 - area.left) / area.width, apart(before) / apart(event));
    } else {
      view.setX(...moved(view.x(), -x / area.width));
      if (view.isYZoomed?.()) view.setY(moved(view.y(), y / area.height));
    }
    fingers.set(event.pointerId, event);
  }, { signal });
  for (const end of ["pointerup", "pointercancel"]) addEventListener(end, (event) => fingers.delete(event.pointerId), { signal });

  box.addEventListener("keydown", (event) => {
    const [from, to] = state.shown, step = event.shiftKey ? 0.1 : 0.01;
    const keys = {
      ArrowLeft: () => pick(state.picked - step * (to - from)), ArrowRight: () => pick(state.picked + step * (to - from)),
      PageUp: () => view.setX(...moved(view.x(), -0.5)), PageDown: () => view.setX(...moved(view.x(), 0.5)),
      "+": () => zoomX(view, view.pickedShare(), 0.5), "-": () => zoomX(view, view.pickedShare(), 2),
      ArrowUp: () => view.setY?.(moved(view.y(), 0.1)), ArrowDown: () => view.setY?.(moved(view.y(), -0.1)),
      "*": () => zoomY(view, 0.5, 0.5), "/": () => zoomY(view, 0.5, 2),
      Home: () => zoom("all"), Escape: () => box.blur(),
    };
    if (event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
    speak(view);
  });
}

let speaking = 0;

/** Have a screen reader say what a plot shows at the picked time, once the keys rest. */
function speak(view) {
  clearTimeout(speaking);
  speaking = setTimeout(() => {
    const [from, to] = state.shown;
    find("#announce").textContent = `${state.picked.toFixed(3)} s of ${from.toFixed(2)} to ${to.toFixed(2)} s: ${view.values() || "no value"}`;
  }, 300);
}
