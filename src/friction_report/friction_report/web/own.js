// A plot of signals of one's own choice, from all numbers of the bag.

/** Lines of the chosen signals, each with a colour of its own. */
const ownLines = () => state.own.map((i, place) => {
  const { topic, field, t, unit, v } = drive.signals[i];
  return { label: `${topic} ${field}`, of: "own", kind: "estimate", colour: `wheel${place % 6}`, axis: "", t, unit, v };
});

function ownPanel(panel, box, width, notes) {
  const chosen = add(notes, "div", undefined, { class: "chosen_signals" });
  const label = add(chosen, "label", "signal ");
  const select = add(label, "select", undefined, { id: "signal" });
  const groups = new Map();
  drive.signals.forEach(({ topic, field }, i) => {
    if (!groups.has(topic)) groups.set(topic, add(select, "optgroup", undefined, { label: topic }));
    add(groups.get(topic), "option", `${topic} ${field}`, { value: String(i) });
  });
  const change = (own) => { state.own = own; rebuild("own", "#signal"); };
  add(chosen, "button", "draw", { type: "button" })
    .addEventListener("click", () => change([...new Set([...state.own, Number(select.value)])]));
  for (const i of state.own) {
    const { topic, field } = drive.signals[i];
    add(chosen, "button", `× ${topic} ${field}`, { type: "button", "aria-label": `remove ${topic} ${field}` })
      .addEventListener("click", () => change(state.own.filter((each) => each !== i)));
  }
  if (state.own.length) select.value = String(state.own[state.own.length - 1]);
  return state.own.length ? linePanel({ ...panel, lines: ownLines() }, box, width, notes) : null;
}
