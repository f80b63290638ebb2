"use strict";
const { columns, rows } = JSON.parse(document.getElementById("data").textContent);
const at = (id) => document.getElementById(id);
const palette = ["#1f5fa8", "#c0392b", "#2e8b57", "#8e44ad", "#b8860b", "#008b8b", "#d2691e", "#555555"];
const title = (c) => (c.measure ? c.name.replace(/_/g, " ") : c.name) + (c.unit ? " [" + c.unit + "]" : "");
const shortName = (c) => (c.measure ? c.name.replace(/_/g, " ") : c.name.split(".").slice(-2).join("."));

function words(value) {
  if (value === null || value === undefined || value === "") return "–";
  if (typeof value !== "number") return String(value);
  if (value === 0 || Number.isInteger(value)) return String(value);
  const size = Math.abs(value);
  return size >= 1e-3 && size < 1e5 ? String(Number(value.toPrecision(4))) : value.toExponential(2);
}
function element(name, attributes, parent, text) {
  const svg = parent && parent.namespaceURI === "http://www.w3.org/2000/svg";
  const made = svg ? document.createElementNS(parent.namespaceURI, name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes || {})) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  if (parent) parent.append(made);
  return made;
}

// ------------------------------------------------------------------ facts
const count = (status) => rows.filter((r) => r.status === status).length;
at("facts").textContent = [
  rows.length + (rows.length === 1 ? " cell" : " cells"),
  count("done") + " done",
  ...["broken", "failed", "missing"].filter(count).map((s) => count(s) + " " + s),
].join(" · ");

// ------------------------------------------------------------------ table
let sorted = -1, falling = false;
const elements = rows.map((row, index) => {
  const tr = document.createElement("tr");
  tr.className = row.status;
  tr.id = "cell-" + index;
  const picture = element("td", { class: "picture" }, tr);
  if (row.picture) {
    const link = element("a", { href: row.picture }, picture);
    element("img", { src: row.picture, loading: "lazy", alt: row.cell }, link);
  }
  const name = element("td", { class: "text" }, tr);
  if (row.report) element("a", { href: row.report }, name, row.cell);
  else name.textContent = row.cell;
  const status = element("td", { class: "text" }, tr);
  element("span", { class: "status" }, status, row.status);
  if (row.reason) {
    element("span", { class: "reason" }, status, row.reason + (row.last_frame >= 0 ? " (last good frame " + row.last_frame + ")" : ""));
    if (row.log) element("a", { href: row.log }, status, "log");
  }
  row.values.forEach((value, c) => {
    const td = element("td", { class: columns[c].numeric ? "" : "text", title: value === null ? "" : value }, tr, words(value));
    if (columns[c].measure && typeof value === "number") {
      const [low, high] = bounds(c);
      if (high > low) element("span", { class: "bar", style: "width:" + (4 + 96 * (value - low) / (high - low)) + "%" }, td);
    }
  });
  tr.addEventListener("mouseenter", () => mark(index, false));
  tr.addEventListener("mouseleave", () => mark(-1, false));
  return tr;
});
function bounds(c) {
  const numbers = (columns[c].bounds ||= (() => {
    const all = rows.map((r) => r.values[c]).filter((v) => typeof v === "number");
    return [Math.min(...all), Math.max(...all)];
  })());
  return numbers;
}
function value(row, c) {
  return c === 0 ? row.cell : c === 1 ? row.status : row.values[c - 2];
}
function sort(c) {
  falling = c === sorted ? !falling : false;
  sorted = c;
  show();
}
function show() {
  const wanted = at("filter").value.trim().toLowerCase().split(/\s+/).filter(Boolean);
  const failed = at("failed").checked;
  const order = rows.map((_, i) => i).filter((i) => {
    const row = rows[i];
    if (failed && row.status !== "failed" && row.status !== "broken") return false;
    const text = (row.cell + " " + row.status + " " + row.reason + " " + row.values.map(words).join(" ")).toLowerCase();
    return wanted.every((word) => text.includes(word));
  });
  if (sorted >= 0)
    order.sort((i, j) => {
      const a = value(rows[i], sorted), b = value(rows[j], sorted);
      if (a === null || b === null) return (a === null) - (b === null);  // what is missing comes last
      const less = typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(String(b));
      return (falling ? -less : less) || i - j;
    });
  at("body").replaceChildren(...order.map((i) => elements[i]));
  at("shown").textContent = order.length === rows.length ? "" : order.length + " of " + rows.length;
  [...at("head").children].forEach((th, c) => {
    if (c > 0 && c - 1 === sorted) th.setAttribute("aria-sort", falling ? "descending" : "ascending");
    else th.removeAttribute("aria-sort");
  });
}
element("th", { class: "picture text" }, at("head"), "");
[{ name: "cell" }, { name: "status" }, ...columns].forEach((c, i) => {
  const th = element("th", { class: i < 2 || !c.numeric ? "text" : "", title: c.meaning || c.name }, at("head"), i < 2 ? c.name : shortName(c));
  if (c.unit) element("small", {}, th, " " + c.unit);
  th.addEventListener("click", () => sort(i));
});
at("filter").addEventListener("input", show);
at("failed").addEventListener("change", show);

// ------------------------------------------------------------------ plot
const svg = at("plot");
const varies = (c) => new Set(rows.map((r) => r.values[c])).size > 1;
function offer(select, choices, chosen) {
  for (const c of choices) element("option", { value: c }, select, c < 0 ? "nothing" : title(columns[c]));
  select.value = String(chosen);
}
const all = columns.map((_, c) => c);
const keys = all.filter((c) => !columns[c].measure && varies(c)), taken = all.filter((c) => columns[c].measure);
const texts = keys.filter((c) => !columns[c].numeric), numbers = keys.filter((c) => columns[c].numeric);
const firstX = numbers[0] ?? keys[0] ?? 0;
offer(at("x"), all, firstX);
offer(at("y"), all.filter((c) => columns[c].numeric), taken[0] ?? numbers[0] ?? 0);
offer(at("colour"), [-1, ...all], texts[0] ?? numbers.find((c) => c !== firstX) ?? -1);
const decades = (c) => columns[c].numeric && bounds(c)[0] > 0 && bounds(c)[1] > 50 * bounds(c)[0];
at("logx").checked = decades(+at("x").value);
at("logy").checked = decades(+at("y").value);
at("x").addEventListener("change", () => { at("logx").checked = decades(+at("x").value); draw(); });
at("y").addEventListener("change", () => { at("logy").checked = decades(+at("y").value); draw(); });
for (const id of ["colour", "logx", "logy"]) at(id).addEventListener("change", draw);

function axis(c, low, high, logarithmic) {
  if (!columns[c].numeric) {
    const names = [...new Set(rows.map((r) => r.values[c]))].sort();
    return {
      place: (v) => low + (names.indexOf(v) + 0.5) / names.length * (high - low),
      ticks: names.length <= 24 ? names.map((n) => [n, n === "" ? "–" : n]) : [], good: () => true,
    };
  }
  const good = (v) => typeof v === "number" && (!logarithmic || v > 0);
  const data = rows.map((r) => r.values[c]).filter(good).map((v) => logarithmic ? Math.log10(v) : v);
  let a = Math.min(...data), b = Math.max(...data);
  if (!data.length) { a = 0; b = 1; }
  const margin = b > a ? 0.04 * (b - a) : Math.abs(a) * 0.1 || 0.5;
  a -= margin; b += margin;
  const place = (v) => low + ((logarithmic ? Math.log10(v) : v) - a) / (b - a) * (high - low);
  const ticks = [];
  if (logarithmic) {
    const factors = b - a > 4 ? [1] : b - a > 1.5 ? [1, 3] : [1, 2, 5];
    for (let e = Math.floor(a) - 1; e <= b; ++e)
      for (const f of factors) {
        const v = Number((f * 10 ** e).toPrecision(6));
        if (Math.log10(v) >= a && Math.log10(v) <= b) ticks.push([v, words(v)]);
      }
  } else {
    const raw = (b - a) / 7, power = 10 ** Math.floor(Math.log10(raw));
    const step = power * [1, 2, 5, 10].find((f) => raw / power <= f);
    for (let v = Math.ceil(a / step) * step; v <= b; v += step) {
      const clean = Number(v.toPrecision(10));
      ticks.push([clean, words(Math.abs(clean) < step * 1e-6 ? 0 : clean)]);
    }
  }
  return { place, ticks, good };
}
function ramp(t) {  // dark blue, green, yellow
  const stops = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [240, 210, 30]];
  const s = Math.max(0, Math.min(0.9999, t)) * (stops.length - 1), i = Math.floor(s), f = s - i;
  return "rgb(" + stops[i].map((v, k) => Math.round(v + f * (stops[i + 1][k] - v))).join(",") + ")";
}
function colours(c) {
  if (c < 0) return { of: () => palette[0], key: [] };
  if (columns[c].numeric) {
    const [low, high] = bounds(c), log = decades(c);
    const share = (v) => high > low ? (log ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low)) : 0.5;
    const mid = log ? Math.sqrt(low * high) : (low + high) / 2;
    return { of: (v) => typeof v === "number" ? ramp(share(v)) : "#bbb", key: [low, mid, high].map((v) => [ramp(share(v)), words(v)]) };
  }
  const names = [...new Set(rows.map((r) => r.values[c]))].sort();
  return {
    of: (v) => palette[names.indexOf(v) % palette.length],
    key: names.slice(0, 12).map((n, i) => [palette[i % palette.length], n === "" ? "–" : n]),
  };
}
let circles = [];
function draw() {
  const cx = +at("x").value, cy = +at("y").value, cc = +at("colour").value;
  const left = 74, right = cc < 0 ? 745 : 640, top = 12, bottom = 376;
  const x = axis(cx, left, right, at("logx").checked && columns[cx].numeric);
  const y = axis(cy, bottom, top, at("logy").checked);
  const colour = colours(cc);
  svg.replaceChildren();
  for (const [v, text] of x.ticks) {
    element("line", { class: "grid", x1: x.place(v), x2: x.place(v), y1: top, y2: bottom }, svg);
    element("text", { x: x.place(v), y: bottom + 18, "text-anchor": "middle" }, svg, text);
  }
  for (const [v, text] of y.ticks) {
    element("line", { class: "grid", x1: left, x2: right, y1: y.place(v), y2: y.place(v) }, svg);
    element("text", { x: left - 8, y: y.place(v) + 4, "text-anchor": "end" }, svg, text);
  }
  element("rect", { class: "frame", x: left, y: top, width: right - left, height: bottom - top }, svg);
  element("text", { class: "title", x: (left + right) / 2, y: 420, "text-anchor": "middle" }, svg, title(columns[cx]));
  element("text", { class: "title", x: 16, y: (top + bottom) / 2, "text-anchor": "middle", transform: "rotate(-90 16 " + (top + bottom) / 2 + ")" }, svg, title(columns[cy]));
  if (cc >= 0) {
    element("text", { x: 654, y: top + 10 }, svg, shortName(columns[cc]).slice(0, 17));
    colour.key.forEach(([fill, text], i) => {
      element("circle", { cx: 661, cy: top + 28 + 19 * i, r: 5, fill }, svg);
      element("text", { x: 672, y: top + 32 + 19 * i }, svg, text.length > 12 ? text.slice(0, 11) + "…" : text);
    });
  }
  const radius = rows.length > 400 ? 3.2 : rows.length > 80 ? 4.2 : 5.5;
  circles = rows.map((row, i) => {
    const vx = row.values[cx], vy = row.values[cy];
    if (!x.good(vx) || !y.good(vy)) return null;
    const dot = element("circle", { cx: x.place(vx), cy: y.place(vy), r: radius, fill: colour.of(cc < 0 ? null : row.values[cc]), "fill-opacity": 0.82 }, svg);
    dot.addEventListener("mouseenter", (event) => { mark(i, false); tip(i, event, [cx, cy]); });
    dot.addEventListener("mouseleave", () => { mark(-1, false); at("tip").hidden = true; });
    dot.addEventListener("click", () => mark(i, true));
    return dot;
  });
}
function tip(i, event, shown) {
  const box = at("tip"), row = rows[i];
  box.replaceChildren();
  if (row.picture) element("img", { src: row.picture }, box);
  element("b", {}, box, row.cell);
  for (const c of shown) element("div", {}, box, shortName(columns[c]) + ": " + words(row.values[c]) + (columns[c].unit ? " " + columns[c].unit : ""));
  box.style.left = Math.min(event.clientX + 14, innerWidth - 250) + "px";
  box.style.top = Math.max(8, Math.min(event.clientY + 14, innerHeight - 230)) + "px";
  box.hidden = false;
}
let marked = -1;
function mark(i, scroll) {
  if (marked >= 0) {
    elements[marked].classList.remove("marked");
    if (circles[marked]) circles[marked].classList.remove("marked");
  }
  marked = i;
  if (i < 0) return;
  elements[i].classList.add("marked");
  if (circles[i]) circles[i].classList.add("marked");
  if (scroll) elements[i].scrollIntoView({ block: "center" });
}
show();
draw();
