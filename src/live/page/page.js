"use strict";
// Shows what the server tells, and asks for nothing but to be told. All text
// is put in as text, never as markup.

const SILENCE_MS = 2500;
const AGAIN_MS = 1000;
const MOST_ROWS = 600;
const element = (id) => document.getElementById(id);
const shown = { run: null, news: null, recent: strip(), whole: strip(), track: { generation: null, places_m: [] } };
let span = "recent";
let heardAt = 0;
let isDrawing = false;

// ---- what is told ----

function strip() {
  return { generation: null, stretch_s: 0.1, first: 0, rows: [] };
}

function takeRows(mine, news) {
  if (mine.generation !== news.generation || news.first < mine.first || news.first > mine.first + mine.rows.length) {
    Object.assign(mine, { generation: news.generation, first: news.first, rows: [] });
  }
  mine.stretch_s = news.stretch_s;
  mine.rows.length = news.first - mine.first;
  mine.rows.push(...news.rows);
  const surplus = Math.max(0, mine.rows.length - MOST_ROWS);
  mine.rows.splice(0, surplus);
  mine.first += surplus;
}

function take(news) {
  if (news.run) {
    Object.assign(shown, { run: news.run, recent: strip(), whole: strip(), happened: null });
    shown.track = { generation: null, places_m: [] };
    tellRun(news.run);
  }
  takeRows(shown.recent, news.recent);
  takeRows(shown.whole, news.whole);
  if (shown.track.generation !== news.track.generation) shown.track = { generation: news.track.generation, places_m: [] };
  shown.track.places_m.push(...news.track.places_m);
  if (news.happened) shown.happened = news.happened;
  if (news.run || news.happened) tellHappened(shown.happened);
  shown.news = news;
  heardAt = performance.now();
  if (news.ended !== null) tellConnection(news.ended === "passed" ? "pass" : "diverges", `over: ${news.ended}`);
  else tellConnection("pass", "live");
  draw();
}

function draw() {
  if (isDrawing || !shown.news) return;
  isDrawing = true;
  requestAnimationFrame(() => {
    isDrawing = false;
    tellNow(shown.news);
    drawPlane(shown);
    drawOverTime(shown, span);
  });
}

// ---- the connection ----

function listen() {
  const updates = new EventSource("/updates");
  updates.onmessage = (message) => take(JSON.parse(message.data));
  updates.onerror = () => {
    if (!shown.news || shown.news.ended === null) tellConnection("fail", "no connection, trying again");
    else tellConnection("diverges", `over: ${shown.news.ended}; this is its last state`);
    if (updates.readyState === EventSource.CLOSED) setTimeout(listen, AGAIN_MS);
  };
}

setInterval(() => {
  const isSilent = shown.news && shown.news.ended === null && performance.now() - heardAt > SILENCE_MS;
  if (isSilent) tellConnection("fail", "nothing heard for some time");
}, SILENCE_MS / 5);

function tellConnection(kind, words) {
  const badge = element("connection");
  badge.className = `badge ${kind}`;
  tell(badge, words);
}

// ---- words and numbers ----

function tell(where, words) {
  const node = typeof where === "string" ? element(where) : where;
  if (node.textContent !== words) node.textContent = words;
}

function number(value, decimals) {
  return value === null || value === undefined ? "–" : value.toFixed(decimals).replace("-", "−");
}

function tellRun(run) {
  document.title = `${run.name}, live`;
  tell("name", run.name);
  const rate = run.bit_rate_bit_s === null ? "" : `, bus at ${run.bit_rate_bit_s / 1000} kbit/s`;
  tell("lead", `${run.program}, T = ${number(run.period_s * 1000, 1)} ms${rate}`);
  tell("duration", run.duration_s === null ? "" : `of ${run.duration_s}`);
  tell("made-by", `canloop ${run.version}.`);
}

function tellNow({ now, drives, frames, load_percent, viewing }) {
  tell("time", number(now.time_s, 2));
  tell("state", now.state ?? "–");
  element("state").className = now.state === "tripped" ? "alarm" : "";
  tell("state-text", now.state === null ? "in another program" : now.state_text === now.state ? "" : now.state_text);
  for (const wheel of ["right", "left"]) {
    tell(`drive-${wheel}`, drives[wheel] ?? "–");
    element(`drive-${wheel}`).className = drives[wheel] === "fault" ? "alarm" : "";
  }
  const areAlike = drives.right === drives.left;
  element("drive-left").hidden = areAlike;
  tell("which-drives", areAlike ? "both" : "right, left");
  const error_mm = now.position_error_m === null ? null : 1000 * now.position_error_m;
  tell("position-error", number(error_mm, 3));
  tell("heading-error", `heading ${number(now.heading_error_rad === null ? null : 1000 * now.heading_error_rad, 3)} mrad`);
  tell("load", number(load_percent, 1));
  tell("frames", `${frames} frames`);
  tellWheels(now);
  tellLost(now, viewing);
}

const WHEELS = [
  ["speed", "speed_rad_s", "rad/s", 3],
  ["speed wanted", "target_speed_rad_s", "rad/s", 3],
  ["torque wanted", "torque_wanted_nm", "N m", 2],
  ["torque sent", "torque_sent_nm", "N m", 2],
  ["torque applied", "torque_applied_nm", "N m", 2],
];

function tellWheels({ right, left }) {
  const cells = ([name, key, unit, decimals]) => [name, number(right[key], decimals), number(left[key], decimals), unit];
  tellTable("wheels", WHEELS.map(cells), ["", "number", "number", "unit"]);
}

function tellLost({ lost, worst_lateness_s, lateness_s }, viewing) {
  // What only a stack can know, and it may be in another program.
  const ofStack = (count) => (lost.periods > 0 ? count : null);
  const counts = [
    ["periods without complete feedback", ofStack(lost.periods_unanswered)],
    ["frames lost on the way here, times", ofStack(lost.frames_lost)],
    ["frames refused as damaged", ofStack(lost.frames_refused)],
    ["feedback late", ofStack(lost.feedback_late)],
    ["feedback repeated", ofStack(lost.feedback_repeated)],
    ["events not shown, for want of room", viewing.events_lost],
    ["updates missed by slow viewers", viewing.updates_missed],
  ];
  const rows = counts.map(([name, count]) => [name, number(count, 0)]);
  if (lateness_s !== null) {
    rows.push(["loop late by, us", number(1e6 * lateness_s, 1)], ["at worst, us", number(1e6 * worst_lateness_s, 1)]);
  }
  tellTable("lost", rows, ["", "number"]);
  counts.forEach(([, count], row) => element("lost").rows[row].cells[1].classList.toggle("some", count > 0));
}

function tellHappened(happened) {
  const rows = (happened?.kept ?? []).map(({ at_s, kind, text, times }) => {
    return [number(at_s, 3), kind, times > 1 ? `${text} (${times} times)` : text];
  });
  rows.reverse();
  if (happened?.forgotten > 0) rows.push(["", "", `and ${happened.forgotten} earlier things; the log has all`]);
  tellTable("happened", rows, ["number", "", "prose"]);
}

function tellTable(id, rows, classes) {
  const body = element(id);
  while (body.rows.length > rows.length) body.deleteRow(-1);
  rows.forEach((cells, nth) => {
    const row = body.rows[nth] ?? body.insertRow();
    cells.forEach((words, column) => {
      const cell = row.cells[column] ?? row.insertCell();
      if (!cell.className) cell.className = classes[column];
      tell(cell, words);
    });
  });
}

// What a chart marks: that a run begins goes without saying.
const UNMARKED = ["boot", "stopped", "enabling", "running", "culprit"];

function marks(happened, from) {
  return (happened?.kept ?? []).filter(({ at_s, kind }) => at_s >= from && !UNMARKED.includes(kind));
}

// ---- pictures ----

const WIDTH = 640;
const HEIGHT = 215;
const PLANE_HEIGHT = 3 * HEIGHT + 36;
const MARGIN = { left: 62, right: 14, top: 30, bottom: 40 };

function node(svg, key, tag, attributes, words) {
  svg.parts ??= new Map();
  let part = svg.parts.get(key);
  if (!part) {
    part = document.createElementNS("http://www.w3.org/2000/svg", tag);
    svg.parts.set(key, part);
    svg.append(part);
  }
  for (const name in attributes) part.setAttribute(name, attributes[name]);
  if (words !== undefined) tell(part, words);
  svg.used.add(key);
}

function picture(id, height, title, draw) {
  const svg = element(id);
  svg.setAttribute("viewBox", `0 0 ${WIDTH} ${height}`);
  svg.used = new Set();
  node(svg, "title", "text", { class: "title", x: MARGIN.left, y: 17 }, title);
  draw(svg);
  for (const [key, part] of svg.parts) {
    if (!svg.used.has(key)) {
      part.remove();
      svg.parts.delete(key);
    }
  }
}

function ticks(from, to, wanted) {
  const rough = (to - from) / wanted;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5].find((factor) => factor * power >= rough) ?? 10);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const all = [];
  for (let value = Math.ceil(from / step - 1e-9) * step; value <= to + 1e-9 * step; value += step) {
    all.push([value, number(Math.abs(value) < 1e-9 * step ? 0 : value, decimals)]);
  }
  return all;
}

function axes(svg, height, x, y, xName, yName, yTicks = 5) {
  const [right, bottom] = [WIDTH - MARGIN.right, height - MARGIN.bottom];
  ticks(x.from, x.to, 6).forEach(([value, words], nth) => {
    node(svg, `x-grid-${nth}`, "path", { class: "grid", d: `M${x.at(value)} ${MARGIN.top}V${bottom}` });
    node(svg, `x-${nth}`, "text", { class: "middle", x: x.at(value), y: bottom + 17 }, words);
  });
  ticks(y.from, y.to, yTicks).forEach(([value, words], nth) => {
    node(svg, `y-grid-${nth}`, "path", { class: "grid", d: `M${MARGIN.left} ${y.at(value)}H${right}` });
    node(svg, `y-${nth}`, "text", { class: "end", x: MARGIN.left - 7, y: y.at(value) + 4 }, words);
  });
  const frame = { class: "frame", x: MARGIN.left, y: MARGIN.top, width: right - MARGIN.left, height: bottom - MARGIN.top };
  node(svg, "frame", "rect", frame);
  node(svg, "x-name", "text", { class: "middle", x: (MARGIN.left + right) / 2, y: height - 6 }, xName);
  const middle = (MARGIN.top + bottom) / 2;
  node(svg, "y-name", "text", { class: "middle", transform: `translate(14 ${middle}) rotate(-90)` }, yName);
}

function scale(from, to, start, end) {
  const factor = (end - start) / (to - from);
  return { from, to, factor, at: (value) => (start + (value - from) * factor).toFixed(1) };
}

// What is drawn last lies on top.
function raise(svg, keys) {
  keys.filter((key) => svg.used.has(key)).forEach((key) => svg.append(svg.parts.get(key)));
}

function legend(svg, entries) {
  let x = WIDTH - MARGIN.right;
  [...entries].reverse().forEach(([role, words]) => {
    x -= 7 * words.length;
    node(svg, `legend-${words}`, "text", { class: "legend", x, y: 17 }, words);
    node(svg, `sample-${words}`, "path", { class: `line ${role}`, d: `M${x - 28} 13h21` });
    x -= 44;
  });
}

function drawPlane({ run, news, track }) {
  const height = PLANE_HEIGHT;
  const robot = news.now.robot;
  const all = [...run.path_m, ...track.places_m];
  if (robot) all.push([robot.x_m, robot.y_m]);
  let [x0, x1, y0, y1] = [Infinity, -Infinity, Infinity, -Infinity];
  for (const [x, y] of all) {
    [x0, x1, y0, y1] = [Math.min(x0, x), Math.max(x1, x), Math.min(y0, y), Math.max(y1, y)];
  }
  const room = { x: WIDTH - MARGIN.left - MARGIN.right, y: height - MARGIN.top - MARGIN.bottom };
  const m_per_px = 1.1 * Math.max((x1 - x0) / room.x, (y1 - y0) / room.y, (6 * run.half_track_m) / room.y);
  const [xm, ym] = [(x0 + x1) / 2, (y0 + y1) / 2];
  const half = { x: (m_per_px * room.x) / 2, y: (m_per_px * room.y) / 2 };
  const x = scale(xm - half.x, xm + half.x, MARGIN.left, WIDTH - MARGIN.right);
  const y = scale(ym - half.y, ym + half.y, height - MARGIN.bottom, MARGIN.top);
  const through = (places) => "M" + places.map(([px, py]) => `${x.at(px)} ${y.at(py)}`).join("L");
  picture("plane", height, "Robot and path", (svg) => {
    axes(svg, height, x, y, "x, m", "y, m", 6);
    node(svg, "path", "path", { class: "line reference dotted", d: through(run.path_m) });
    if (track.places_m.length > 1) node(svg, "track", "path", { class: "line response", d: through(track.places_m) });
    if (robot) {
      const [w, l] = [run.half_track_m * x.factor, 1.3 * run.half_track_m * x.factor];
      const size = Math.max(1, 7 / w);
      const d = `M${l} 0L${-l * 0.6} ${w}L${-l * 0.6} ${-w}Z`;
      const turn = (-robot.heading_rad * 180) / Math.PI;
      const transform = `translate(${x.at(robot.x_m)} ${y.at(robot.y_m)}) rotate(${turn.toFixed(2)}) scale(${size.toFixed(3)})`;
      node(svg, "robot", "path", { class: "robot", d, transform, "vector-effect": "non-scaling-stroke" });
    }
    const wanted = news.now.reference;
    if (wanted) {
      node(svg, "wanted", "circle", { class: "line reference", cx: x.at(wanted.x_m), cy: y.at(wanted.y_m), r: 4.5 });
    }
    legend(svg, [["reference dotted", "path"], ["response", "robot"]]);
    raise(svg, ["path", "track", "robot", "wanted"]);
  });
}

// A signal as the band between its least and its greatest value.
function band(strip, x, y, pick) {
  const [upper, lower] = [[], []];
  let d = "";
  const close = () => {
    if (upper.length) d += `M${upper.join("L")}L${lower.reverse().join("L")}Z`;
    upper.length = lower.length = 0;
  };
  strip.rows.forEach((row, nth) => {
    const range = pick(row);
    if (range === null) return close();
    const at = x.at((strip.first + nth + 0.5) * strip.stretch_s);
    upper.push(`${at} ${y.at(range[1])}`);
    lower.push(`${at} ${y.at(range[0])}`);
  });
  close();
  return d;
}

function extremes(strip, picks) {
  let [low, high] = [Infinity, -Infinity];
  for (const row of strip.rows) {
    for (const pick of picks) {
      const range = pick(row);
      if (range) [low, high] = [Math.min(low, range[0]), Math.max(high, range[1])];
    }
  }
  return low <= high ? [low, high] : [0, 0];
}

function drawOverTime({ run, news, recent, whole, happened }, span) {
  const strip = span === "recent" ? recent : whole;
  const until = Math.max(news.now.time_s, 1);
  const from = span === "recent" ? Math.max(0, until - 60) : 0;
  const x = scale(from, until, MARGIN.left, WIDTH - MARGIN.right);
  const y = (low, high) => scale(low, high, HEIGHT - MARGIN.bottom, MARGIN.top);
  const mark = (svg) => {
    marks(happened, from).forEach(({ at_s }, nth) => {
      node(svg, `mark-${nth}`, "path", { class: "marker", d: `M${x.at(at_s)} ${MARGIN.top}V${HEIGHT - MARGIN.bottom}` });
    });
  };
  const line = (svg, scaleY, role, pick) => {
    const key = `line-${role}`;
    node(svg, key, "path", { class: `line area ${role}`, d: band(strip, x, scaleY, pick) });
    raise(svg, [key]);
  };

  const error = (row) => row.position_error_m?.map((metres) => 1000 * metres) ?? null;
  picture("error-chart", HEIGHT, "Distance from the path", (svg) => {
    const scaleY = y(0, 1.1 * Math.max(extremes(strip, [error])[1], 0.01));
    axes(svg, HEIGHT, x, scaleY, "time, s", "distance, mm");
    mark(svg);
    line(svg, scaleY, "response", error);
  });

  const torques = { right: (row) => row.torque_right_nm, left: (row) => row.torque_left_nm };
  picture("torque-chart", HEIGHT, news.now.right.torque_sent_nm === null ? "Torque at the wheels" : "Torque sent", (svg) => {
    const [low, high] = extremes(strip, Object.values(torques));
    const most = 1.1 * Math.max(run.torque_limit_nm, -low, high);
    const scaleY = y(-most, most);
    axes(svg, HEIGHT, x, scaleY, "time, s", "torque, N m");
    mark(svg);
    for (const limit of [run.torque_limit_nm, -run.torque_limit_nm]) {
      const d = `M${MARGIN.left} ${scaleY.at(limit)}H${WIDTH - MARGIN.right}`;
      node(svg, `limit-${Math.sign(limit)}`, "path", { class: "limit", d });
    }
    for (const wheel in torques) line(svg, scaleY, wheel, torques[wheel]);
    raise(svg, ["limit-1", "limit--1"]);
    legend(svg, [["right", "right"], ["left", "left"], ["limit", "limit"]]);
  });

  const load = (row) => {
    const percent = (100 * row.bits) / strip.stretch_s / run.bit_rate_bit_s;
    return [percent, percent];
  };
  const title = run.bit_rate_bit_s === null ? "Bus load: the bit rate is not known" : "Bus load";
  picture("load-chart", HEIGHT, title, (svg) => {
    // The last row is not over yet.
    const over = { ...strip, rows: run.bit_rate_bit_s === null ? [] : strip.rows.slice(0, -1) };
    const scaleY = y(0, 1.1 * Math.max(extremes(over, [load])[1], 1));
    axes(svg, HEIGHT, x, scaleY, "time, s", "load, %");
    mark(svg);
    node(svg, "line-response", "path", { class: "line response", d: band(over, x, scaleY, load) });
    raise(svg, ["line-response"]);
  });
}

// ---- the time shown ----

element("span").addEventListener("click", ({ target }) => {
  if (!target.dataset.span) return;
  span = target.dataset.span;
  for (const button of element("span").children) button.setAttribute("aria-pressed", String(button === target));
  draw();
});

listen();
