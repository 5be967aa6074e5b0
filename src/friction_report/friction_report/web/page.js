// Lays the page out. Everything of the bag is set as text, never as HTML.

const MAKERS = { curve: curvePanel, mu_proven: trackPanel, mu_lower: trackPanel, sign: stripPanel, supervisor: stripPanel, validity: stripPanel, own: ownPanel };

/** A panel below its heading: the tools, the plot, what its dashes and colours stand for, and its numbers as a table. */
function addPanel(panel, section) {
  const head = add(section, "div", undefined, { class: "head" });
  add(head, "h2", panel.title);
  const box = add(section, "div", undefined, { class: "plot" }), notes = add(section, "div");
  const view = MAKERS[panel.key] ? MAKERS[panel.key](panel, box, section.clientWidth, notes) : linePanel(panel, box, section.clientWidth, notes);
  if (panel.remarks?.length) add(section, "p", panel.remarks.join("; "), { class: "remark" });
  if (!view) return { key: panel.key, section, destroy: () => {} };
  for (const [name, value] of Object.entries({ tabindex: 0, role: "application", "aria-label": `plot: ${panel.title}`, "aria-describedby": "keys" }))
    box.setAttribute(name, value);
  const listening = new AbortController(), { destroy } = view;
  listen(view, box, listening.signal);
  addTools(head, panel, view);
  addNumbers(section, view);
  return Object.assign(view, { key: panel.key, section, destroy: () => { listening.abort(); destroy(); } });
}

/** Buttons of a panel: one stop of the tab key, arrows between them. */
function addTools(head, panel, view) {
  const tools = add(head, "div", undefined, { class: "tools", role: "toolbar", "aria-label": `${panel.title}: tools` });
  const tool = (text, label, run) => add(tools, "button", text, { type: "button", "aria-label": label, title: label, tabindex: tools.children.length ? -1 : 0 })
    .addEventListener("click", run);
  if (view.setY) {
    tool("y +", "zoom the values in", () => zoomY(view, 0.5, 0.5));
    tool("y −", "zoom the values out", () => zoomY(view, 0.5, 2));
    tool("y auto", "show all values", () => view.setY(null));
  }
  tool("CSV", "save what is shown as CSV", () => saveCsv(view.table(), panel.key));
  tool("PNG", "save what is shown as PNG", () => savePng(view, panel.title, panel.key));
  tools.addEventListener("keydown", (event) => {
    const to = { ArrowLeft: event.target.previousElementSibling, ArrowRight: event.target.nextElementSibling }[event.key];
    if (!to) return;
    event.preventDefault();
    event.target.tabIndex = -1;
    to.tabIndex = 0;
    to.focus();
  });
}

/** The numbers of a plot as a table that follows it while it is open; a line is shown or hidden there, too. */
function addNumbers(section, view) {
  const details = add(section, "details", undefined, { class: "numbers" });
  add(details, "summary", "numbers");
  const table = add(add(details, "div", undefined, { class: "scroll" }), "table");
  const fill = () => {
    if (!details.open) return;
    const focused = [...table.querySelectorAll("input")].indexOf(document.activeElement);
    table.replaceChildren();
    const { headings: texts, rows } = view.numbers(), body = headings(table, texts.map((text, i) => [text, "", i ? "" : "text"]));
    for (const { label, line, cells, flip } of rows) {
      const row = add(body, "tr"), name = add(row, "th", flip ? undefined : label, { scope: "row", class: "text" });
      if (flip) {
        const shown = add(add(name, "label"), "input", undefined, { type: "checkbox" });
        shown.checked = !line.off;
        shown.addEventListener("change", () => { flip(); fill(); });
        shown.after(` ${label}`);
      }
      for (const cell of cells) add(row, "td", cell);
    }
    table.querySelectorAll("input")[focused]?.focus();
  };
  details.addEventListener("toggle", fill);
  for (const event of ["onPick", "onShow", "onVisible"]) {
    const before = view[event];
    view[event] = () => { before?.(); fill(); };
  }
}

function build() {
  for (const view of panels.splice(0)) view.destroy();
  readTheme();
  const host = find("#panels");
  host.replaceChildren();
  for (const panel of drive.panels) {
    const section = add(host, "section", undefined, { class: "panel", id: `panel_${panel.key}` });
    panels.push(addPanel(panel, section));
  }
  show(...state.shown);
}

/** Make one panel again and give the focus to what `selector` finds in it. */
function rebuild(key, selector) {
  const place = panels.findIndex((view) => view.key === key), { section } = panels[place];
  panels[place].destroy();
  section.replaceChildren();
  panels[place] = addPanel(drive.panels.find((panel) => panel.key === key), section);
  section.querySelector(selector)?.focus();
}

function fillControls() {
  const box = find("#wheels");
  const toggle = (text, name, flip) => {
    const button = add(box, "button", undefined, { type: "button", "aria-pressed": "true" });
    if (name) add(button, "i").style.background = `var(--${name})`;
    button.append(text);
    button.addEventListener("click", () => {
      button.setAttribute("aria-pressed", String(flip()));
      for (const view of panels) view.onVisible?.();
    });
  };
  for (const of of drive.wheels)
    toggle(of === "vehicle" ? "car" : of, colourName(of), () => (state.hidden.delete(of) ? true : (state.hidden.add(of), false)));
  if (drive.lines.some((line) => line.kind === "truth")) toggle("true values", null, () => (state.truth = !state.truth));
  for (const button of document.querySelectorAll("[data-zoom]"))
    button.addEventListener("click", () => zoom(button.dataset.zoom));
  find("#drag").addEventListener("click", (event) => {
    state.drag = state.drag === "pan" ? "zoom" : "pan";
    event.target.setAttribute("aria-pressed", String(state.drag === "pan"));
  });
  find("#pick input").addEventListener("input", (event) => pick(Number(event.target.value)));
}

fillHeader();
fillBrakings();
fillControls();
fillTopics();
build();
let pageWidth = innerWidth;
addEventListener("resize", () => { if (innerWidth !== pageWidth) { pageWidth = innerWidth; build(); } });
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", build);
const setPaper = (paper) => {
  document.documentElement.classList.toggle("paper", paper);
  find("#panels").style.width = paper ? "700px" : "";
  build();
};
addEventListener("beforeprint", () => setPaper(true));
addEventListener("afterprint", () => setPaper(false));
