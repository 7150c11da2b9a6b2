"use strict";
(() => {
const fail = (what) => { document.documentElement.dataset.error = String(what); };
addEventListener("error", (event) => fail(event.message));

// Columns of a result row, as `row` writes them.
const SCENE = 0, AREA = 1, ORACLE = 2, PROFILE = 3, MODE = 4, GUID = 5, CLASS = 6, KNOWN = 7, FRAMES = 8, EXACT = 9, FIRST = 10,
  ERRORS = 11, STAGES = 12, DETAIL = 13, UNDEFINED = 14, TOLERATED = 15;
const SHOWN = 300;
const SVG = "http://www.w3.org/2000/svg";

const $ = (id) => document.getElementById(id);
const data = JSON.parse($("data").textContent);
const rows = data.results;
// From the best to the worst; the class of a row is an index.
const VERDICTS = data.verdicts;

/// An element with attributes and children; strings become text, never markup.
function make(name, attributes = {}, ...children) {
  const svg = name.startsWith("svg:");
  const element = svg ? document.createElementNS(SVG, name.slice(4)) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (value !== null && value !== undefined && value !== false) element.setAttribute(key, value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}
const s = (name, attributes, ...children) => make("svg:" + name, attributes, ...children);
const number = (value) => value.toLocaleString("en");
const size = (value) => value === null ? "not finite" : value === 0 ? "0" : value >= 0.01 && value < 1e5 ? String(+value.toPrecision(4)) : value.toExponential(2);
const verdict = (row) => make("span", { class: "verdict v" + row[CLASS] }, VERDICTS[row[CLASS]]);
/// The field that is furthest off: its error is what sorts.
const worst = (row) => row[ERRORS].reduce((best, error) => best === null || (error[1] ?? Infinity) > (best[1] ?? Infinity) ? error : best, null);
const worstSize = (row) => { const error = worst(row); return error ? error[1] ?? Infinity : -1; };
const key = (row) => [row[SCENE], row[ORACLE], row[MODE], row[GUID]].join("|");

// ---- What is shown: it lives in the fragment, so that a view can be kept as a link.
const FILTERS = { area: AREA, oracle: ORACLE, profile: PROFILE, mode: MODE };
let view = {};
function readFragment() {
  view = Object.fromEntries(new URLSearchParams(location.hash.slice(1)));
}
function fragment(changes) {
  const next = new URLSearchParams();
  for (const [name, value] of Object.entries({ ...view, ...changes })) if (value) next.set(name, value);
  return "#" + next.toString();
}
function go(changes, replace = false) {
  const next = fragment(changes);
  if (replace) { history.replaceState(null, "", next); show(); } else location.hash = next;
}

// ---- Summary
function summary() {
  const t = data.totals;
  const tiles = [
    [number(t.exact), "of " + number(t.results) + " results exact"],
    ...data.counts.filter(([name, count]) => name !== "exact" && (count || name === "new" || name === "changed")).map(([name, count]) => [number(count), name]),
    [number(t.frames_exact), "of " + number(t.frames_compared) + " frames exact"],
  ];
  if (t.frames_undefined_in_oracle) tiles.push([number(t.frames_undefined_in_oracle), "frames undefined in the oracle"]);
  if (t.stage_records_not_run) tiles.push([number(t.stage_records_not_run), "stage records not run"]);
  $("tiles").append(...tiles.map(([value, text]) => make("div", { class: "tile" }, make("b", {}, value), text)));
  const scenes = new Set(rows.map((row) => row[SCENE])).size;
  const unique = (index) => [...new Set(rows.map((row) => row[index]))].sort().join(", ");
  $("subtitle").textContent = number(scenes) + " scenes; oracles: " + unique(ORACLE) + "; profiles: " + unique(PROFILE) + "; ac-conform " + data.version;
  $("areas").append(make("details", {}, make("summary", {}, "Exact results by area and mode"), areas()));
  notes();
}
/// What is not in the table of results: what could not run, what was skipped, what may differ.
function notes() {
  const list = (title, open, items) => { if (items.length) $("notes").append(make("details", open ? { open: "" } : {}, make("summary", {}, title), make("ul", {}, ...items.map((item) => make("li", {}, ...item))))); };
  list(number(data.errors.length) + " could not run", true, data.errors.map((text) => [text]));
  list(number(data.flaky.length) + " flaky: the second run said something else", true, data.flaky.map(([scene, what]) => [make("b", {}, scene), " – " + what]));
  list(number(data.skipped.length) + " skipped by the policy", true, data.skipped.map(([scene, reason]) => [make("b", {}, scene), " – " + reason]));
  list(number(data.rules.length) + " rules of the policy: what may differ, and why", false, data.rules.map(([scope, title, used]) =>
    [make("code", {}, title), " (" + scope + ") – " + (used ? number(used) + " differences passed by it" : "nothing needed it")]));
}
function areas() {
  const names = [...new Set(rows.map((row) => row[AREA]))].sort(), modes = [...new Set(rows.map((row) => row[MODE]))];
  const cells = new Map();
  for (const row of rows) {
    const at = row[AREA] + "|" + row[MODE], cell = cells.get(at) ?? [0, 0];
    cell[0] += row[CLASS] === 0; cell[1] += 1; cells.set(at, cell);
  }
  return make("table", {}, make("thead", {}, make("tr", {}, make("th", { scope: "col" }, "area"), ...modes.map((mode) => make("th", { class: "n", scope: "col" }, mode)))),
    make("tbody", {}, ...names.map((name) => make("tr", {}, make("td", {}, make("a", { href: "#area=" + encodeURIComponent(name) }, name)), ...modes.map((mode) => {
      const cell = cells.get(name + "|" + mode);
      return make("td", { class: "n" }, cell ? make("span", { class: cell[0] === cell[1] ? "v0-text" : "bad-text" }, cell[0] + "/" + cell[1]) : "–");
    })))));
}

// ---- Table
const COLUMNS = [
  ["scene", "Scene", (row) => row[SCENE]], ["area", "Area", (row) => row[AREA]], ["oracle", "Oracle", (row) => row[ORACLE]],
  ["profile", "Profile", (row) => row[PROFILE]], ["mode", "Mode", (row) => row[MODE]], ["verdict", "Verdict", (row) => row[CLASS]],
  ["frames", "Frames exact", (row) => row[EXACT] / Math.max(1, row[FRAMES]), "n"], ["first", "First divergence", (row) => row[FIRST] ? row[FIRST][0] : Infinity],
  ["error", "Largest error", worstSize],
];
/// Everything the text filter looks at.
const haystack = rows.map((row) => [row[SCENE], row[ORACLE], row[PROFILE], row[MODE], row[GUID], VERDICTS[row[CLASS]], ...row[TOLERATED].map(([rule]) => rule), ...(row[FIRST] ? row[FIRST].slice(1, 5) : [])].join(" ").toLowerCase());
let order = [], limit = SHOWN;
function select() {
  const words = (view.filter ?? "").toLowerCase().split(/\s+/).filter(Boolean);
  order = rows.map((_, index) => index).filter((index) =>
    words.every((word) => haystack[index].includes(word))
    && Object.entries(FILTERS).every(([name, column]) => !view[name] || rows[index][column] === view[name])
    && (!view.verdict || VERDICTS[rows[index][CLASS]] === view.verdict));
  const sort = view.sort ?? "", column = COLUMNS.find((column) => column[0] === sort.replace("-", ""));
  if (!column) return;
  const sign = sort.startsWith("-") ? -1 : 1, value = column[2];
  order.sort((a, b) => { const x = value(rows[a]), y = value(rows[b]); return sign * (x < y ? -1 : x > y ? 1 : 0) || a - b; });
}
function head() {
  const sort = view.sort ?? "";
  $("results").tHead.replaceChildren(make("tr", {}, ...COLUMNS.map(([id, name, , kind]) => {
    const up = sort === id, down = sort === "-" + id;
    return make("th", { scope: "col", class: kind, "aria-sort": up ? "ascending" : down ? "descending" : "none" },
      make("button", { type: "button", "data-sort": id, onclick: () => { go({ sort: up ? "-" + id : down ? "" : id }, true); document.querySelector("[data-sort=" + id + "]").focus(); } }, name + (up ? " ▲" : down ? " ▼" : "")));
  })));
}
function line(index) {
  const row = rows[index], first = row[FIRST], error = worst(row);
  return make("tr", { "data-index": index, onclick: (event) => { if (!event.target.closest("a")) go({ open: key(row) }); } },
    make("td", {}, make("a", { href: fragment({ open: key(row) }) }, row[SCENE]), " ", make("span", { class: "small" }, row[GUID])),
    make("td", {}, row[AREA]), make("td", {}, row[ORACLE]), make("td", {}, row[PROFILE]), make("td", {}, row[MODE]), make("td", {}, verdict(row)),
    make("td", { class: "n" }, number(row[EXACT]) + " / " + number(row[FRAMES])),
    make("td", {}, first ? "frame " + first[0] + ", " + (first[1] ? first[1] + " " : "") : "–", first ? make("code", {}, first[2]) : null),
    make("td", {}, error ? size(error[1]) + " " + error[4] + " " : "–", error ? make("code", {}, error[0]) : null));
}
function table() {
  select(); head();
  $("results").tBodies[0].replaceChildren(...order.slice(0, limit).map(line));
  $("count").textContent = number(order.length) + " of " + number(rows.length) + " results";
  $("more").hidden = order.length <= limit;
  $("more").textContent = "Show all " + number(order.length);
}
function filters() {
  const fill = (id, values) => $(id).replaceChildren(make("option", { value: "" }, "all"), ...values.map((value) => make("option", { value }, value)));
  for (const [name, column] of Object.entries(FILTERS)) fill("f-" + name, [...new Set(rows.map((row) => row[column]))].sort());
  fill("f-verdict", VERDICTS);
  for (const name of ["filter", "verdict", ...Object.keys(FILTERS)]) $("f-" + name).addEventListener("input", (event) => { limit = SHOWN; go({ [name]: event.target.value }, true); });
  $("filters").addEventListener("submit", (event) => event.preventDefault());
  $("f-clear").addEventListener("click", () => { view = {}; go({}, true); });
  $("more").addEventListener("click", () => { limit = Infinity; table(); });
  $("skip").addEventListener("click", (event) => { event.preventDefault(); $("f-filter").focus(); });
}

// ---- Detail
/// Undoes `track`: points [x, y, z] or null.
function points(track) {
  const axes = track.axes.map(([low, step, ...differences]) => { let sum = 0; return differences.map((d) => low + step * (sum += d)); });
  const gaps = new Set(track.gaps), length = track.outcomes.length;
  return Array.from({ length }, (_, index) => gaps.has(index) ? null : [axes[0][index], axes[1][index], axes[2][index]]);
}
/// Distance walked so far, and height: the side view.
function side(path) {
  let walked = 0, last = null;
  return path.map((point) => {
    if (!point) return null;
    if (last) walked += Math.hypot(point[0] - last[0], point[1] - last[1]);
    last = point;
    return [walked, point[2]];
  });
}
function scale(values, low, high, least) {
  let from = Infinity, to = -Infinity;
  for (const value of values) { if (value < from) from = value; if (value > to) to = value; }
  if (from > to) { from = 0; to = 1; }
  const pad = Math.max(least - (to - from), 0) / 2;
  from -= pad; to += pad;
  const map = (value) => low + (value - from) / (to - from) * (high - low);
  return Object.assign(map, { from, to });
}
function pathText(path, x, y) {
  let text = "", pen = false;
  for (const point of path) {
    if (!point) { pen = false; continue; }
    text += (pen ? "L" : "M") + x(point[0]).toFixed(1) + " " + y(point[1]).toFixed(1);
    pen = true;
  }
  return text;
}
const short = (value) => String(+value.toPrecision(6));
function plot(title, across, up, sides, equal, same) {
  const width = 560, height = 320, left = 64, right = 14, top = 10, bottom = 34;
  const all = sides.flatMap(([, path]) => path.filter(Boolean));
  let x = scale(all.map((point) => point[0]), left, width - right, 0.1), y = scale(all.map((point) => point[1]), height - bottom, top, 0.1);
  if (equal) {
    // One metre is as long across as up.
    const per = Math.max((x.to - x.from) / (width - left - right), (y.to - y.from) / (height - top - bottom));
    x = scale(all.map((point) => point[0]), left, width - right, per * (width - left - right));
    y = scale(all.map((point) => point[1]), height - bottom, top, per * (height - top - bottom));
  }
  const svg = s("svg", { viewBox: "0 0 " + width + " " + height, role: "img", "aria-label": title },
    s("path", { class: "axis", d: "M" + left + " " + top + "V" + (height - bottom) + "H" + (width - right) }),
    s("text", { x: left, y: height - bottom + 14 }, short(x.from)), s("text", { x: width - right, y: height - bottom + 14, "text-anchor": "end" }, short(x.to)),
    s("text", { x: (left + width - right) / 2, y: height - 6, "text-anchor": "middle" }, across),
    s("text", { x: left - 5, y: height - bottom, "text-anchor": "end" }, short(y.from)), s("text", { x: left - 5, y: top + 10, "text-anchor": "end" }, short(y.to)),
    s("text", { x: 12, y: (top + height - bottom) / 2, "text-anchor": "middle", transform: "rotate(-90 12 " + (top + height - bottom) / 2 + ")" }, up));
  for (const [name, path] of sides) {
    svg.append(s("path", { class: "path " + name, d: pathText(path, x, y) }));
    const start = path.find(Boolean);
    if (start && name === "expected") svg.append(s("circle", { class: "dot expected", cx: x(start[0]), cy: y(start[1]), r: 4 }, s("title", {}, "start")));
  }
  return make("div", { class: "card" }, make("h3", {}, title), svg,
    make("div", { class: "legend" }, ...sides.map(([name]) => make("span", {}, make("i", { class: name }), name)), make("span", {}, "○ start"),
      same ? make("span", {}, "the client's path is the same") : null));
}
/// Frame of a point, when `count` points stand for all frames.
const frameAt = (frames, count, index) => count < 2 ? frames[0] : frames[0] + index / (count - 1) * (frames[1] - frames[0]);
function errorPlot(row, detail, errors) {
  const names = Object.keys(errors);
  const card = make("div", { class: "card" }, make("h3", {}, "Error of each field over time (log scale)"));
  if (!names.length) { card.append(make("p", { class: "muted" }, "No number differs in any frame.")); return card; }
  const decode = (text) => Array.from(text, (c) => c === "." ? null : (c.charCodeAt(0) - 47) / 5 - 10);
  const series = names.map((name) => [name, decode(errors[name])]).map(([name, list]) => [name, list, list.reduce((a, b) => b === null ? a : Math.max(a, b), -Infinity)]).sort((a, b) => b[2] - a[2]).slice(0, 6);
  const width = 1120, height = 260, left = 56, right = 14, top = 10, bottom = 34, count = series[0][1].length;
  const lowest = Math.floor(Math.min(...series.map(([, list]) => Math.min(...list.filter((v) => v !== null))))), highest = Math.ceil(Math.max(...series.map(([, , max]) => max)));
  const y = scale([lowest, Math.max(highest, lowest + 1)], height - bottom, top, 0), x = (frame) => left + (frame - detail.frames[0]) / Math.max(1, detail.frames[1] - detail.frames[0]) * (width - left - right);
  const svg = s("svg", { viewBox: "0 0 " + width + " " + height, role: "img", "aria-label": "Error over time" });
  const stride = Math.max(1, Math.ceil((y.to - y.from) / 7));
  for (let decade = y.from; decade <= y.to; decade += stride) svg.append(s("path", { class: "axis", d: "M" + left + " " + y(decade) + "H" + (width - right) }), s("text", { x: left - 5, y: y(decade) + 4, "text-anchor": "end" }, "1e" + decade));
  svg.append(s("text", { x: left, y: height - bottom + 16 }, "frame " + detail.frames[0]), s("text", { x: width - right, y: height - bottom + 16, "text-anchor": "end" }, "frame " + detail.frames[1]));
  if (row[FIRST]) svg.append(s("path", { class: "first-mark", d: "M" + x(row[FIRST][0]) + " " + top + "V" + (height - bottom) }, s("title", {}, "first divergence")));
  series.forEach(([name, list], index) => {
    const at = list.map((value, point) => value === null ? null : [frameAt(detail.frames, count, point), value]);
    const style = "stroke:var(--s" + index + ");fill:none";
    svg.append(s("path", { class: "path", style, d: pathText(at, x, y) }, s("title", {}, name)));
    // A frame that differs alone has no line: it gets a dot.
    at.forEach((point, i) => { if (point && !at[i - 1] && !at[i + 1]) svg.append(s("circle", { cx: x(point[0]), cy: y(point[1]), r: 2, style: "fill:var(--s" + index + ")" }, s("title", {}, name))); });
  });
  card.append(svg, make("div", { class: "legend" }, ...series.map(([name], index) => make("span", {}, make("i", { style: "border-color:var(--s" + index + ")" }), name)),
    names.length > 6 ? make("span", { class: "muted" }, "the six largest of " + names.length + " fields") : null, row[FIRST] ? make("span", { class: "muted" }, "dotted: first divergence") : null));
  return card;
}
function timeline(row, detail, sides) {
  const width = 1120, left = 130, right = 14, bar = 18, frames = detail.frames;
  const x = (frame) => left + (frame - frames[0]) / Math.max(1, frames[1] + 1 - frames[0]) * (width - left - right);
  const svg = s("svg", { viewBox: "0 0 " + width + " " + (sides.length * 2 * (bar + 6) + 24), role: "img", "aria-label": "Outcomes and cells over time" });
  let y = 4;
  const used = new Set();
  for (const [name, track] of sides) {
    svg.append(s("text", { x: left - 6, y: y + 13, "text-anchor": "end" }, "outcome, " + name));
    const text = track.outcomes, at = (index) => left + index / text.length * (width - left - right);
    for (let from = 0; from < text.length;) {
      let to = from;
      while (to < text.length && text[to] === text[from]) to += 1;
      if (text[from] !== "-") { used.add(+text[from]); svg.append(s("rect", { class: "o" + text[from], x: at(from), y, width: Math.max(0.5, at(to) - at(from)), height: bar }, s("title", {}, data.outcomes[+text[from]]))); }
      from = to;
    }
    y += bar + 6;
  }
  for (const [name, track] of sides) {
    svg.append(s("text", { x: left - 6, y: y + 13, "text-anchor": "end" }, "cell, " + name));
    track.cells.forEach(([frame, cell], index) => {
      const from = x(frame), to = index + 1 < track.cells.length ? x(track.cells[index + 1][0]) : width - right;
      svg.append(s("rect", { class: "c" + index % 2, x: from, y, width: Math.max(0.5, to - from), height: bar }, s("title", {}, cell + " from frame " + frame)));
      if (to - from > 66) svg.append(s("text", { x: from + 4, y: y + 13 }, cell));
    });
    y += bar + 6;
  }
  if (row[FIRST]) svg.append(s("path", { class: "first-mark", d: "M" + x(row[FIRST][0]) + " 0V" + y }));
  svg.append(s("text", { x: left, y: y + 12 }, "frame " + frames[0]), s("text", { x: width - right, y: y + 12, "text-anchor": "end" }, "frame " + frames[1]));
  return make("div", { class: "card" }, make("h3", {}, "Outcomes and cells"), svg,
    make("div", { class: "legend" }, ...[...used].sort().map((index) => make("span", {}, make("span", { class: "swatch o" + index }), data.outcomes[index])),
      make("span", { class: "muted" }, "the worst outcome of each slice of time"), sides.some(([, track]) => track.cells.length >= 200) ? make("span", {}, "only the first 200 changes of cell") : null));
}
function firstCard(row) {
  const first = row[FIRST];
  if (!first) return make("div", { class: "card fine" }, make("h3", {}, "No divergence"), "All " + number(row[FRAMES]) + (row[MODE] === "stage" ? " stage records" : " frames") + " have the same bits as the oracle's.", row[UNDEFINED] ? " " + number(row[UNDEFINED]) + " of them expect a value that is not finite; that it is met says nothing about retail." : "");
  const entry = (name, value) => value === null ? [] : [make("dt", {}, name), make("dd", {}, value)];
  return make("div", { class: "card first" }, make("h3", {}, "First divergence: frame " + first[0] + ", ", make("code", {}, first[2])),
    make("dl", { class: "values" }, ...entry("stage", first[1]), ...entry("expected", make("code", {}, first[3])), ...entry("actual", make("code", {}, first[4])),
      ...entry("apart", first[5] === null ? null : size(first[6]) + ", " + first[5].replace(/\B(?=(\d{3})+$)/g, ",") + " ULP"),
      ...entry("read", make("code", {}, first[7])), ...entry("baseline", row[KNOWN])));
}
/// How the modes of a scene, an oracle and an entity agree, and what that says.
function agreement(row, siblings) {
  const of = (mode) => siblings.find((other) => other[ORACLE] === row[ORACLE] && other[MODE] === mode);
  const [free, resync, stage] = ["free", "resync", "stage"].map(of), told = [free, resync, stage].filter(Boolean);
  if (told.length < 2) return null;
  const wrong = (other) => other && other[FIRST], place = (other) => "frame " + other[FIRST][0] + (other[FIRST][1] ? ", stage " + other[FIRST][1] : "") + ", " + other[FIRST][2];
  const names = told.map((other) => other[MODE] + (wrong(other) ? " differs (" + place(other) + ")" : " does not differ")).join("; ") + ". ";
  let says;
  if (!told.some(wrong)) says = "All agree.";
  else if (wrong(stage)) says = wrong(free) || wrong(resync)
    ? "The stage run alone differs too: look there first."
    : "Only the stage run alone differs: its record lacks an input, or the record is wrong where nothing reads it.";
  else if (wrong(free) && wrong(resync)) says = free[FIRST][0] === resync[FIRST][0]
    ? "Both part in the same frame, from the right state before it" + (stage ? ", though every stage alone is right: look at the order of the stages and at what lies between them." : ".")
    : "The free run parts first by itself; resync shows how often it would again.";
  else if (wrong(free)) says = "Every frame is right when the one before is: something that no record carries goes wrong earlier, or at creation, and adds up.";
  else says = "Only from the recorded states it differs: they lack some state that the free run has. The client is right.";
  return make("div", { class: "card", id: "agreement" }, make("h3", {}, "Do the modes agree?"), names + says);
}
function tables(row) {
  const build = (names, lines) => make("table", {}, make("thead", {}, make("tr", {}, ...names.map((name, index) => make("th", { scope: "col", class: index ? "n" : null }, name)))),
    make("tbody", {}, ...lines.map((cells) => make("tr", {}, ...cells.map((cell, index) => make("td", { class: index ? "n" : null }, cell))))));
  const out = [];
  if (row[TOLERATED].length) out.push(make("div", { class: "card", id: "tolerated" }, make("h3", {}, "Passed by a rule of the policy"), build(["rule, and why", "times"], row[TOLERATED].map(([rule, count]) => [rule, number(count)]))));
  if (row[STAGES].length) out.push(make("div", { class: "card" }, make("h3", {}, "Stages"), build(["stage", "records", "exact", "not run"], row[STAGES].map(([name, compared, exact, not]) => [name, number(compared), number(exact), number(not)]))));
  if (row[ERRORS].length) out.push(make("div", { class: "card" }, make("h3", {}, "Largest errors"), build(["field", "largest error", "unit", "largest ULP", "in frame"], row[ERRORS].map(([field, abs, ulp, frame, unit]) => [field, size(abs), unit, ulp.replace(/\B(?=(\d{3})+$)/g, ","), String(frame)]))));
  return out;
}
function detail(index) {
  const row = rows[index];
  const siblings = rows.filter((other) => other[SCENE] === row[SCENE] && other[GUID] === row[GUID]);
  const oracles = [...new Set(siblings.map((other) => other[ORACLE]))];
  const pick = (oracle, mode) => siblings.find((other) => other[ORACLE] === oracle && other[MODE] === mode) ?? siblings.find((other) => other[ORACLE] === oracle);
  const button = (text, target, on) => make("button", { type: "button", "aria-pressed": String(on), onclick: () => go({ open: key(target) }) }, text);
  const block = row[DETAIL] === null ? null : JSON.parse($("d" + row[DETAIL]).textContent);
  const body = [
    make("p", {}, make("a", { href: fragment({ open: "" }) }, "← All results")),
    make("h1", {}, row[SCENE]), make("p", { class: "muted" }, "entity " + row[GUID] + ", oracle " + row[ORACLE] + ", profile " + row[PROFILE] + ", mode " + row[MODE] + " – ", verdict(row), " – " + number(row[EXACT]) + " of " + number(row[FRAMES]) + (row[MODE] === "stage" ? " records" : " frames") + " exact"),
    make("div", { class: "bar", role: "group", "aria-label": "Oracle and mode" }, ...oracles.map((oracle) => button(oracle, pick(oracle, row[MODE]), oracle === row[ORACLE])), make("span", { class: "muted" }, "·"),
      ...siblings.filter((other) => other[ORACLE] === row[ORACLE]).map((other) => button(other[MODE], other, other === row))),
    firstCard(row), agreement(row, siblings),
  ];
  const mode = block?.modes[row[MODE]];
  if (block) {
    const sides = [["expected", block.expected]];
    if (mode?.actual) sides.push(["actual", mode.actual]);
    const paths = sides.map(([name, track]) => [name, points(track)]);
    body.push(make("div", { class: "grid" },
      plot("From above", "x, east (m)", "y, north (m)", paths.map(([name, path]) => [name, path.map((p) => p && [p[0], p[1]])]), true, mode && !mode.actual),
      plot("From the side", "distance walked (m)", "z (m)", paths.map(([name, path]) => [name, side(path)]), false, mode && !mode.actual)));
    if (mode) body.push(errorPlot(row, block, mode.errors));
    body.push(timeline(row, block, sides));
  }
  body.push(...tables(row));
  if (row[MODE] === "stage" && block) body.push(make("p", { class: "muted" }, "Stages run alone have no path of their own: the plots show what is expected."));
  $("detail").replaceChildren(...body.filter(Boolean));
}

let opened = null;
function show() {
  readFragment();
  const index = view.open ? rows.findIndex((row) => key(row) === view.open) : -1;
  const open = index >= 0;
  for (const name of ["filter", "verdict", ...Object.keys(FILTERS)]) if ($("f-" + name).value !== (view[name] ?? "")) $("f-" + name).value = view[name] ?? "";
  select();
  $("list").hidden = open; $("detail").hidden = !open;
  if (open) { detail(index); opened = index; scrollTo(0, 0); $("detail").focus(); } else {
    table();
    if (opened !== null) { document.querySelector('tr[data-index="' + opened + '"] a')?.focus(); opened = null; }
  }
}
function keys(event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const typing = /^(INPUT|SELECT)$/.test(event.target.tagName), open = view.open && !$("detail").hidden;
  if (event.key === "Escape") { if (open) go({ open: "" }); else if (typing) event.target.blur(); return; }
  if (typing) return;
  if (event.key === "/" && !open) { event.preventDefault(); $("f-filter").focus(); }
  if ((event.key === "]" || event.key === "[") && open) {
    const place = order.indexOf(opened), next = order[place + (event.key === "]" ? 1 : -1)];
    if (next !== undefined) go({ open: key(rows[next]) }, true);
  }
  if ((event.key === "ArrowDown" || event.key === "ArrowUp") && !open) {
    const links = [...document.querySelectorAll("#results tbody a")], at = links.indexOf(document.activeElement);
    const next = links[event.key === "ArrowDown" ? at + 1 : at - 1];
    if (next && at >= 0 || next && event.key === "ArrowDown") { event.preventDefault(); next.focus(); }
  }
}

summary(); filters(); show();
addEventListener("hashchange", show);
addEventListener("keydown", keys);
document.documentElement.dataset.ready = Math.round(performance.now());
})();
