// The tables of brakings and topics, and the facts above them.

function chooseRow(row) {
  for (const each of document.querySelectorAll("tr.braking")) {
    each.classList.toggle("chosen", each === row);
    each.querySelector("button").setAttribute("aria-pressed", String(each === row));
  }
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
    find("#brakings .tools").remove();
    find("#brakings .hint").textContent = "No braking: the car's speed is not known, or it never falls by 1 m/s with more than 1 m/s².";
    return;
  }
  const body = headings(table, [["start", "[s]"], ["grip used", "largest [-]"], ["µ_max", "most certain [-]"], ["λ_max", "most certain [-]"],
    ["valid", "of the time"], ["speed", "[m/s]"], ["deceleration", "mean / largest [m/s²]"], ["duration", "[s]"], ["largest slip", "above 5 m/s [-]"]]);
  for (const b of drive.brakings) {
    const row = add(body, "tr", undefined, { class: "braking" });
    add(add(row, "td"), "button", number(b.start, 2), { type: "button", "aria-pressed": "false", "aria-label": `show the braking from ${number(b.start, 2)} s` });
    for (const [name, digits] of [["mu_used", 2], ["mu_max", 3], ["lambda_max", 3]]) {
      const cell = add(row, "td");
      for (const part of b.parts) if (part[name][0] !== null || (part.reason && name === "mu_max")) add(cell, "div", valueOf(part, name, digits, b.parts.length > 1));
    }
    const valid = add(row, "td");
    for (const part of b.parts) if (part.valid !== null) add(valid, "div", `${(100 * part.valid).toFixed(0)}\u00a0%`);
    add(row, "td", `${number(b.from, 1)}\u00a0–\u00a0${number(b.to, 1)}`);
    add(row, "td", `${number(b.deceleration, 1)}\u00a0/\u00a0${number(b.hardest, 1)}`);
    add(row, "td", number(b.end - b.start, 2));
    add(row, "td", b.slip === null ? "–" : `${number(b.slip, 3)} ${b.slip_of}`);
    const choose = () => {
      chooseRow(row);
      const margin = Math.max(0.3, 0.1 * (b.end - b.start));
      state.picked = (b.start + b.end) / 2;
      show(b.start - margin, b.end + margin);
    };
    row.addEventListener("click", choose);
  }
  find("#brakings .tools button").addEventListener("click", () => saveCsv(brakingTable(), "brakings"));
}

/** The brakings as rows of a table, one for each part of the car. */
function brakingTable() {
  const numbers = { start: "start [s]", end: "end [s]", from: "from [m/s]", to: "to [m/s]", deceleration: "mean deceleration [m/s²]",
    hardest: "largest deceleration [m/s²]", slip: "largest slip above 5 m/s [-]" };
  const values = { mu_used: "grip used [-]", mu_max: "µ_max [-]", lambda_max: "λ_max [-]" };
  const rows = drive.brakings.flatMap((b) => b.parts.map((part) => [...Object.keys(numbers).map((name) => b[name] ?? ""), part.of,
    ...Object.keys(values).flatMap((name) => part[name].map((value) => value ?? "")), part.valid ?? "", part.reason]));
  return { headings: [...Object.values(numbers), "of", ...Object.values(values).flatMap((text) => [text, `half of the 95 % interval of ${text}`]),
    "share of valid curves [-]", "reason"], rows };
}

/** A value with half of its 95 % interval, or the reason why there is none; the part of the car where there are several. */
const valueOf = (part, name, digits, several) => {
  const [value, reach] = part[name];
  const text = value === null ? part.reason : reach === null ? number(value, digits) : `${number(value, digits)}\u00a0±\u00a0${number(reach, digits)}`;
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

function fillHeader() {
  for (const [name, text] of drive.facts) {
    if (text) { add(find("#facts"), "dt", name); add(find("#facts"), "dd", text); }
    else add(find("#remarks"), "li", name);
  }
  if (drive.absent.length) add(find("#remarks"), "li", `Not shown: ${drive.absent.join("; ")}`);
  for (const text of drive.problems) add(find("#remarks"), "li", `damaged: ${text}`);
}
