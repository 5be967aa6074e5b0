// What a plot shows, as a table (CSV) and as a picture (PNG).

/** Save a text or a picture as a file of the reader's. */
function save(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = `${drive.title}_${name}`.replace(/[^\p{L}\p{N}._-]+/gu, "_");
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** A cell after RFC 4180; text that a spreadsheet would run as a formula is kept from it by a space. */
function csvCell(cell) {
  const text = typeof cell === "number" ? String(cell) : /^[=+@\t\r-](?![\d.]+$)/.test(cell) ? ` ${cell}` : cell;
  return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

function saveCsv({ headings, rows }, name) {
  const text = [headings, ...rows].map((row) => row.map(csvCell).join(",")).join("\r\n");
  save(new Blob(["\ufeff", text, "\r\n"], { type: "text/csv;charset=utf-8" }), `${name}.csv`);
}

/** The plot as it is shown, below its title and above what its colours and dashes stand for. */
function savePng(view, title, name) {
  const source = view.plot().ctx.canvas, ratio = source.width / source.clientWidth, pad = 12 * ratio, row = 18 * ratio;
  const canvas = document.createElement("canvas"), ctx = canvas.getContext("2d");
  const font = theme.font.replace("11px", `${12 * ratio}px`);
  ctx.font = font;
  const keys = view.keys().map((key) => ({ ...key, width: ctx.measureText(key.label).width + (key.colour ? 30 : 10) * ratio + pad }));
  let x = 0, rows = 1;
  for (const key of keys) {
    if (x && x + key.width > source.width) { x = 0; rows++; }
    Object.assign(key, { x, row: rows - 1 });
    x += key.width;
  }
  canvas.width = source.width + 2 * pad;
  canvas.height = source.height + 2 * pad + row + rows * row;
  ctx.fillStyle = colour("page");
  ctx.fillRect(0, 0, canvas.width, canvas.height);
  ctx.fillStyle = colour("ink");
  ctx.font = `bold ${font}`;
  ctx.textBaseline = "middle";
  ctx.fillText(fitted(ctx, `${title}, ${drive.title}`, source.width), pad, pad + row / 2);
  ctx.drawImage(source, pad, pad + row);
  ctx.font = font;
  for (const key of keys) {
    const left = pad + key.x, middle = 1.5 * pad + row + source.height + (key.row + 0.5) * row;
    if (key.colour) {
      ctx.fillStyle = ctx.strokeStyle = key.colour;
      ctx.lineWidth = 2 * ratio;
      ctx.setLineDash((key.dash ?? []).map((part) => part * ratio));
      if (key.filled) ctx.fillRect(left, middle - 5 * ratio, 10 * ratio, 10 * ratio);
      else if (key.hollow) ctx.strokeRect(left, middle - 4 * ratio, 8 * ratio, 8 * ratio);
      else { ctx.beginPath(); ctx.moveTo(left, middle); ctx.lineTo(left + 22 * ratio, middle); ctx.stroke(); }
    }
    ctx.fillStyle = colour("ink");
    ctx.fillText(key.label, left + (key.colour ? 28 * ratio : 0), middle);
  }
  canvas.toBlob((blob) => save(blob, `${name}.png`));
}
