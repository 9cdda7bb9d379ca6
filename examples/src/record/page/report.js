(() => {
const data = JSON.parse(document.getElementById('data').textContent);
const begin = data.begin, grid = begin.grid, [nx, ny] = grid.size, flap = begin.system === 'flap';
const $ = (id) => document.getElementById(id);
const size = nx * ny;
const end = Math.max(data.last, 0.1);
const clamp = (v, low, high) => Math.min(Math.max(v, low), high);
const fixed = (v, digits = 1) => v.toFixed(digits);

// ---------------------------------------------------------------- what was recorded
const cellEvents = new Reader(data.cells).events((r) => ({ runs: r.runs() }));
const frontierEvents = new Reader(data.frontiers).events((r) => ({ runs: r.runs() }));
const regionEvents = new Reader(data.regions).events((r) => {
  const runs = r.runs(), list = r.list(3), centers = new Map();
  for (let k = 0; k < list.length; k += 3) centers.set(list[k], [list[k + 1] / 100, list[k + 2] / 100]);
  return { runs, centers };
});
const decisions = new Reader(data.decisions).events((r) => {
  const outcome = ['go', 'wait', 'done'][r.int()], ahead = !!r.int(), chosen = r.int() - 1, list = r.list(11), regions = r.list(1);
  const candidates = [];
  for (let k = 0; k < list.length; k += 11) {
    candidates.push({ ...viewOf(list, k), base: [list[k + 7] / 100, list[k + 8] / 100], gain: list[k + 9], seconds: list[k + 10] / 10 });
  }
  return { outcome, ahead, chosen, candidates, regions };
});
const plans = new Reader(data.plans).events((r, t) => {
  const ready = t + r.int() / 1000, step = r.int() / 1000, list = r.list(5), base = [], camera = [];
  for (let k = 0; k < list.length; k += 5) {
    base.push([list[k] / 100, list[k + 1] / 100]);
    camera.push([list[k + 2] / 100, list[k + 3] / 100, list[k + 4] / 100]);
  }
  return { ready, step, base, camera, goal: viewOf(Array.from({ length: 7 }, () => r.int())) };
});
const horizons = new Reader(data.horizons).events((r) => {
  const list = r.list(2), base = [];
  for (let k = 0; k < list.length; k += 2) base.push([list[k] / 100, list[k + 1] / 100]);
  return { base };
});
const rowsOf = ({ rows, columns }, read) => Array.from({ length: rows }, (_, i) => read(columns.map((c) => c[i])));
const poses = table(data.poses);
const poseTimes = poses.rows ? poses.columns[0].map((t) => t / 1000) : [];
const reached = rowsOf(table(data.reached), (r) => ({ t: r[0] / 1000, ...viewOf(r, 1) }));
const progress = rowsOf(table(data.progress), ([t, explored, inspected, found, activity]) =>
  ({ t: t / 1000, explored: explored / 1e4, inspected: inspected / 1e4, found, activity: data.activities[activity] }));
const stages = Object.entries(data.stages).map(([name, text]) =>
  ({ name, rows: rowsOf(table(text), ([t, calls, total, max]) => ({ t: t / 1000, calls, total: total / 1000, max: max / 1000 })) }));
const sampledList = new Reader(data.sampled), sampled = [];
if (sampledList.more) for (let list = sampledList.list(7), k = 0; k < list.length; k += 7) sampled.push(viewOf(list, k));
const looks = data.looks.map((look) => ({ ...look, view3: { p: look.camera.p, q: look.camera.q } }));
const found = data.found, tags = begin.ground.tags;
const foundAt = new Map(found.map((f) => [f.id, f.t]));
const cells = new Field(cellEvents, size), frontiers = new Field(frontierEvents, size), regions = new Field(regionEvents, size);
// In a FLAP search: what looks saw, apart from what was known before.
const seen = new Field(new Reader(data.seen).events((r) => ({ runs: r.runs() })), size);

// ---------------------------------------------------------------- layers
const REGION = [[219, 234, 254], [220, 252, 231], [254, 243, 199], [252, 231, 243], [237, 233, 254], [207, 250, 254], [255, 237, 213], [226, 232, 240], [236, 252, 203], [254, 226, 226]];
const rgb = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));
const SURFACE = { open: '#f2994a', partly: '#b59f5b', inspected: '#2f6b57', plain: '#8b95a3' };
const COLOR = { explore: '#e11d48', inspect: '#2563eb', candidate: '#7c3aed', chosen: '#c026d3', base: '#0f172a', horizon: '#ea580c', found: '#16a34a', missing: '#9ca3af' };
const heightColor = (() => {
  const stops = [[0.2, [59, 15, 112]], [0.75, [140, 41, 129]], [1.2, [222, 73, 104]], [1.7, [254, 159, 50]]];
  return (z) => {
    let k = 0;
    while (k < stops.length - 2 && z > stops[k + 1][0]) k++;
    const f = clamp((z - stops[k][0]) / (stops[k + 1][0] - stops[k][0]), 0, 1);
    return `rgb(${stops[k][1].map((v, a) => Math.round(v + f * (stops[k + 1][1][a] - v)))})`;
  };
})();
const LAYERS = flap ? [
  ['known', 'known space', '#ffffff', true], ['seen', 'seen by looks', '#86efac', true], ['volumes', 'volumes to search', '#fca5a5', true],
  ['sampled', 'sampled views', '#94a3b8', true], ['looks', 'views in order', '#1d4ed8', true], ['frustum', 'field of view', '#f59e0b', true],
  ['base', 'base moves, drawn straight', COLOR.base, true], ['scene', 'true walls', '#475569', true],
] : [
  ['known', 'explored', '#ffffff', true], ['surface', 'surface: open, inspected', `linear-gradient(90deg, ${SURFACE.open} 50%, ${SURFACE.inspected} 50%)`, true],
  ['explore', 'exploration frontier', COLOR.explore, true], ['inspect', 'inspection frontier', COLOR.inspect, true],
  ['regions', 'regions, order', '#bfdbfe', true], ['candidates', 'candidate views', COLOR.candidate, true], ['chosen', 'chosen view', COLOR.chosen, true],
  ['base', 'base path', COLOR.base, true], ['camera', 'camera path, by height', 'linear-gradient(90deg, rgb(59,15,112), rgb(222,73,104), rgb(254,159,50))', true],
  ['horizon', 'MPC horizon', COLOR.horizon, true], ['frustum', 'field of view', '#f59e0b', true], ['reached', 'reached views', '#0891b2', false],
  ['tags', 'tags', COLOR.found, true], ['given', 'given up', '#7f1d1d', false], ['scene', 'true walls', '#475569', true],
];
const on = Object.fromEntries(LAYERS.map(([name, , , shown]) => [name, shown]));
for (const [index, [name, label, swatch]] of LAYERS.entries()) {
  const box = document.createElement('label'), input = document.createElement('input'), mark = document.createElement('i');
  input.type = 'checkbox'; input.checked = on[name]; input.dataset.layer = name;
  if (index < 9) box.title = `key ${index + 1}`;
  mark.style.background = swatch;
  if (name === 'known') mark.style.border = '1px solid #9ca3af';
  input.addEventListener('change', () => { on[name] = input.checked; redraw(); });
  box.append(input, mark, label);
  $('layers').append(box);
}

// ---------------------------------------------------------------- time
let now = end, playing = false, last = 0;
const slider = $('time');
slider.max = end; slider.step = 0.1;
const SPEEDS = [1, 2, 5, 10, 20, 50, 100];
for (const speed of SPEEDS) $('speed').add(new Option(`${speed}×`, speed));
$('speed').value = SPEEDS.find((s) => end / s <= 45) || 100;

function seek(time) {
  now = clamp(time, 0, end);
  slider.value = now;
  redraw();
}
function play(start) {
  if (start && now >= end - 1e-6) now = 0;
  playing = start; last = 0;
  $('play').innerHTML = start ? '&#10074;&#10074;' : '&#9654;';
  $('play').setAttribute('aria-label', start ? 'Pause' : 'Play');
  if (start) requestAnimationFrame(frame);
}
function frame(stamp) {
  if (!playing) return;
  if (last) seek(now + (Math.min(stamp - last, 200) / 1000) * Number($('speed').value));
  last = stamp;
  if (now >= end) play(false); else requestAnimationFrame(frame);
}
slider.addEventListener('input', () => { play(false); seek(Number(slider.value)); });
$('play').addEventListener('click', () => play(!playing));
document.addEventListener('keydown', (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.tagName === 'SELECT') return;
  const step = event.shiftKey ? 10 : 1;
  const jump = (forward) => {
    const times = flap ? looks.map((l) => l.t) : decisions.map((d) => d.t);
    const next = forward ? times.find((t) => t > now + 1e-3) : times.findLast((t) => t < now - 1e-3);
    seek(next ?? (forward ? end : 0));
  };
  const digit = LAYERS[Number(event.key) - 1];
  const actions = {
    ArrowLeft: () => seek(now - step), ArrowRight: () => seek(now + step), PageDown: () => seek(now - 30), PageUp: () => seek(now + 30),
    Home: () => seek(0), End: () => seek(end), n: () => jump(true), p: () => jump(false), f: fit,
    '+': () => zoom(1.25), '-': () => zoom(0.8), ' ': () => play(!playing),
  };
  if (event.key === ' ' && (event.target.tagName === 'BUTTON' || event.target.tagName === 'INPUT' && event.target.type === 'checkbox' || event.target.tagName === 'SUMMARY')) return;
  if (digit && event.key >= '1' && event.key <= '9') {
    document.querySelector(`[data-layer=${digit[0]}]`).click();
  } else if (actions[event.key]) {
    if (event.key.startsWith('Arrow') || event.key === 'Home' || event.key === 'End') play(false);
    actions[event.key]();
  } else return;
  event.preventDefault();
});

// ---------------------------------------------------------------- canvases
const map = $('map'), pen = map.getContext('2d');
const raster = document.createElement('canvas');
raster.width = nx; raster.height = ny;
const rasterPen = raster.getContext('2d'), image = rasterPen.createImageData(nx, ny);
// World to canvas: x right, y up, `scale` pixels a metre, `middle` in the centre.
const camera = { scale: 1, middle: [0, 0], fitted: true };
const ground = begin.ground, extent = [ground.high[0] - ground.low[0], ground.high[1] - ground.low[1]];
const X = (x) => map.clientWidth / 2 + (x - camera.middle[0]) * camera.scale;
const Y = (y) => map.clientHeight / 2 - (y - camera.middle[1]) * camera.scale;

// Sets a canvas to its shown size in device pixels; null while it is not shown.
function prepare(canvas) {
  const ratio = window.devicePixelRatio || 1, w = canvas.clientWidth, h = canvas.clientHeight;
  if (!w || !h) return null;
  if (canvas.width !== Math.round(w * ratio) || canvas.height !== Math.round(h * ratio)) {
    canvas.width = Math.round(w * ratio); canvas.height = Math.round(h * ratio);
  }
  const context = canvas.getContext('2d');
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, w, h);
  context.font = '12px system-ui, "DejaVu Sans", sans-serif';
  context.textBaseline = 'alphabetic';
  context.textAlign = 'left';
  return { c: context, w, h };
}
function fit() {
  const w = map.clientWidth, h = map.clientHeight, bottom = 30, edge = 10;
  camera.scale = Math.max(Math.min((w - 2 * edge) / extent[0], (h - bottom - edge) / extent[1]), 1);
  camera.middle = [0, 1].map((a) => (ground.low[a] + ground.high[a]) / 2);
  camera.middle[1] -= (bottom - edge) / 2 / camera.scale;
  camera.fitted = true;
  redraw();
}
function zoom(factor, x = map.clientWidth / 2, y = map.clientHeight / 2) {
  const scale = clamp(camera.scale * factor, 4, 2000), k = 1 / camera.scale - 1 / scale;
  camera.middle[0] += (x - map.clientWidth / 2) * k;
  camera.middle[1] -= (y - map.clientHeight / 2) * k;
  camera.scale = scale; camera.fitted = false;
  redraw();
}
const pointers = new Map();
map.addEventListener('pointerdown', (e) => { map.setPointerCapture(e.pointerId); pointers.set(e.pointerId, [e.offsetX, e.offsetY]); });
for (const name of ['pointerup', 'pointercancel']) map.addEventListener(name, (e) => pointers.delete(e.pointerId));
map.addEventListener('pointermove', (e) => {
  const before = pointers.get(e.pointerId);
  if (!before) return;
  const spread = () => { const [a, b] = [...pointers.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
  const wide = pointers.size === 2 ? spread() : 0;
  camera.middle[0] -= (e.offsetX - before[0]) / camera.scale / pointers.size;
  camera.middle[1] += (e.offsetY - before[1]) / camera.scale / pointers.size;
  pointers.set(e.pointerId, [e.offsetX, e.offsetY]);
  camera.fitted = false;
  if (wide) { const [a, b] = [...pointers.values()]; zoom(spread() / wide, (a[0] + b[0]) / 2, (a[1] + b[1]) / 2); } else redraw();
});
map.addEventListener('wheel', (e) => { e.preventDefault(); zoom(Math.exp(-clamp(e.deltaY, -240, 240) / 400), e.offsetX, e.offsetY); }, { passive: false });
map.addEventListener('dblclick', fit);
$('closer').addEventListener('click', () => zoom(1.25));
$('farther').addEventListener('click', () => zoom(0.8));
$('fit').addEventListener('click', fit);

// ---------------------------------------------------------------- the map
const UNKNOWN = [203, 208, 216], PARTLY = [229, 232, 237], FREE = [255, 255, 255];
const CLASS = [UNKNOWN, PARTLY, FREE, rgb(SURFACE.plain), rgb(SURFACE.open), rgb(SURFACE.partly), rgb(SURFACE.inspected)];
const mix = (a, b, f) => [0, 1, 2].map((k) => a[k] + f * (b[k] - a[k]));
function paintCells() {
  const state = cells.at(now), front = frontiers.at(now), region = regions.at(now), looked = flap ? seen.at(now) : null;
  const explore = rgb(COLOR.explore), inspect = rgb(COLOR.inspect);
  for (let row = 0, i = 0; row < ny; row++) {
    for (let column = 0; column < nx; column++, i++) {
      const kind = state[i];
      let color = CLASS[kind];
      if (!on.known && kind > 0 && kind < 3) color = UNKNOWN;
      else if (kind === 2 && on.regions && region[i]) color = REGION[(region[i] - 1) % REGION.length];
      if (kind >= 3 && on.surface === false) color = CLASS[3];
      if (looked && on.seen && looked[i]) color = kind >= 3 ? [21, 128, 61] : [187, 247, 208];
      if (on.explore && front[i] & 1) color = mix(color, explore, 0.72);
      // Where a part of the wall is done the blue lets it through.
      if (on.inspect && front[i] & 2) color = mix(color, inspect, kind === 5 && on.surface ? 0.45 : 0.8);
      const at = 4 * ((ny - 1 - row) * nx + column);
      image.data[at] = color[0]; image.data[at + 1] = color[1]; image.data[at + 2] = color[2]; image.data[at + 3] = 255;
    }
  }
  rasterPen.putImageData(image, 0, 0);
}
function path(points, close) {
  pen.beginPath();
  points.forEach((p, k) => (k ? pen.lineTo(X(p[0]), Y(p[1])) : pen.moveTo(X(p[0]), Y(p[1]))));
  if (close) pen.closePath();
}
function stroke(points, color, width, dash = []) {
  if (points.length < 2) return;
  path(points);
  pen.setLineDash(dash); pen.strokeStyle = color; pen.lineWidth = width; pen.lineJoin = 'round'; pen.stroke();
  pen.setLineDash([]);
}
function byHeight(points, width, alpha) {
  pen.globalAlpha = alpha;
  for (let k = 1; k < points.length; k++) stroke([points[k - 1], points[k]], heightColor((points[k - 1][2] + points[k][2]) / 2), width);
  pen.globalAlpha = 1;
}
// Corners of what a camera covers, down to the floor, seen from above.
function reach(view, range) {
  const [h, v] = begin.robot.camera;
  return [[-h, -v], [h, -v], [h, v], [-h, v]].map(([x, y]) => {
    const length = Math.hypot(x, y, 1), d = rotate(view.q, [x / length, y / length, 1 / length]);
    const far = d[2] < -1e-3 ? Math.min(range, view.p[2] / -d[2]) : range;
    return [view.p[0] + far * d[0], view.p[1] + far * d[1], view.p[2] + far * d[2]];
  });
}
function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (list) => {
    const out = [];
    for (const p of list) {
      while (out.length > 1) {
        const [a, b] = out.slice(-2);
        if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) break;
        out.pop();
      }
      out.push(p);
    }
    return out.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}
function frustum(view, range, color, fill, width = 1.5) {
  const corners = reach(view, range);
  path(hull([view.p, ...corners]), true);
  pen.fillStyle = color; pen.globalAlpha = fill; pen.fill(); pen.globalAlpha = 1;
  pen.strokeStyle = color; pen.lineWidth = width; pen.stroke();
  for (const corner of corners) { pen.globalAlpha = 0.35; stroke([view.p, corner], color, 1); pen.globalAlpha = 1; }
}
function dot(p, radius, fill, line) {
  pen.beginPath(); pen.arc(X(p[0]), Y(p[1]), radius, 0, 7); pen.fillStyle = fill; pen.fill();
  if (line) { pen.strokeStyle = line; pen.lineWidth = 1.5; pen.stroke(); }
}
const FONT = '12px system-ui, "DejaVu Sans", sans-serif';
function text(label, x, y, color, { bold = true, align = 'left' } = {}) {
  pen.font = (bold ? 'bold ' : '') + FONT;
  pen.textAlign = align; pen.lineWidth = 3; pen.strokeStyle = 'rgba(255,255,255,.9)'; pen.lineJoin = 'round';
  pen.strokeText(label, x, y); pen.fillStyle = color; pen.fillText(label, x, y);
  pen.textAlign = 'left';
}
function badge(p, label, color) {
  dot(p, 9, color, '#ffffff');
  pen.font = 'bold 11px system-ui, "DejaVu Sans", sans-serif'; pen.textAlign = 'center'; pen.fillStyle = '#ffffff';
  pen.fillText(label, X(p[0]), Y(p[1]) + 4); pen.textAlign = 'left';
}
function wedge(view, color, length, half = 3.2) {
  const axis = rotate(view.q, [0, 0, 1]), n = Math.hypot(axis[0], axis[1]) || 1, d = [axis[0] / n, axis[1] / n];
  const x = X(view.p[0]), y = Y(view.p[1]), steep = Math.max(n, 0.25) * length;
  pen.beginPath(); pen.moveTo(x + steep * d[0], y - steep * d[1]);
  pen.lineTo(x - half * d[1] - 2 * d[0], y - half * d[0] + 2 * d[1]); pen.lineTo(x + half * d[1] - 2 * d[0], y + half * d[0] + 2 * d[1]); pen.closePath();
  pen.fillStyle = color; pen.fill();
}

// Where the robot is at a time, between the poses before and after.
function poseAt(time) {
  if (!poses.rows) return null;
  const i = clamp(until(poseTimes, time) - 1, 0, poses.rows - 1), j = Math.min(i + 1, poses.rows - 1);
  const f = j > i ? clamp((time - poseTimes[i]) / (poseTimes[j] - poseTimes[i]), 0, 1) : 0;
  const at = (c) => poses.columns[c][i] + f * (poses.columns[c][j] - poses.columns[c][i]);
  const arm = [];
  for (let c = 11; c + 2 < poses.columns.length; c += 3) arm.push([at(c) / 100, at(c + 1) / 100, at(c + 2) / 100]);
  return { index: i, base: [at(1) / 100, at(2) / 100, at(3) / 1000], view: viewOf([4, 5, 6, 7, 8, 9, 10].map(at)), arm };
}
const fromBase = ([x, y, yaw], p) => [x + Math.cos(yaw) * p[0] - Math.sin(yaw) * p[1], y + Math.sin(yaw) * p[0] + Math.cos(yaw) * p[1]];
function drawRobot(base, arm) {
  const [[x0, y0], [x1, y1]] = begin.robot.base;
  path([[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map((p) => fromBase(base, p)), true);
  pen.fillStyle = 'rgba(30, 41, 59, .8)'; pen.fill(); pen.strokeStyle = '#ffffff'; pen.lineWidth = 1.5; pen.stroke();
  stroke([fromBase(base, [x1 * 0.55, 0]), fromBase(base, [x1 + 0.08, 0])], '#facc15', 2.5);
  if (arm) {
    const points = arm.map((p) => fromBase(base, p));
    stroke(points, '#ffffff', 4.5); stroke(points, '#f59e0b', 2.5);
    dot(points[points.length - 1], 3, '#f59e0b', '#ffffff');
  }
}
function drawScene() {
  for (const { corners, band } of ground.outlines) {
    path(corners, true);
    const tall = band[1] > 2;
    pen.fillStyle = tall ? 'rgba(30, 41, 59, .16)' : 'rgba(120, 90, 50, .08)'; pen.fill();
    pen.strokeStyle = tall ? '#334155' : 'rgba(71, 60, 45, .65)'; pen.lineWidth = tall ? 1 : 0.8; pen.stroke();
  }
}
function drawTags() {
  for (const tag of tags) {
    const at = foundAt.get(tag.id), is = at !== undefined && at <= now + 1e-6, x = X(tag.center[0]), y = Y(tag.center[1]);
    if (is && now - at < 2.5 && at > 0) { pen.beginPath(); pen.arc(x, y, 8 + 8 * (now - at), 0, 7); pen.strokeStyle = COLOR.found; pen.lineWidth = 2; pen.stroke(); }
    pen.fillStyle = is ? COLOR.found : '#ffffff'; pen.strokeStyle = is ? '#ffffff' : '#6b7280'; pen.lineWidth = 1.5;
    pen.fillRect(x - 5.5, y - 5.5, 11, 11); pen.strokeRect(x - 5.5, y - 5.5, 11, 11);
    const label = is ? `${tag.id}: ${fixed(at, 0)} s` : `${tag.id}`, right = x + 70 > map.clientWidth;
    text(label, right ? x - 9 : x + 9, y + 4, is ? '#166534' : '#4b5563', { align: right ? 'right' : 'left' });
  }
}
function trail(columns, from, time) {
  const out = [], n = until(poseTimes, time);
  let before = null;
  for (let i = Math.max(until(poseTimes, from) - 1, 0); i < n; i++) {
    const p = columns.map((c) => poses.columns[c][i] / 100);
    if (before && i < n - 1 && Math.hypot(p[0] - before[0], p[1] - before[1]) < 0.04) continue;
    out.push(p); before = p;
  }
  return out;
}
function drawHeats() {
  const pose = poseAt(now), decision = latest(decisions, now), plan = latest(plans, now);
  const event = on.regions && latest(regionEvents, now), centers = event ? event.centers : new Map();
  const order = decision ? decision.regions.filter((id) => centers.has(id)).map((id) => centers.get(id)) : [];
  stroke(order, '#475569', 1.2, [2, 4]);
  if (on.scene) drawScene();
  // What is long ago is pale, so that a long run stays readable.
  const fresh = Math.max(now - 90, 0);
  if (on.base) {
    pen.globalAlpha = 0.28; stroke(trail([1, 2], 0, fresh), COLOR.base, 1.4); pen.globalAlpha = 1;
    const way = trail([1, 2], fresh, now); stroke(way, '#ffffff', 3.6); stroke(way, COLOR.base, 1.8);
  }
  if (on.camera) { byHeight(trail([4, 5, 6], 0, fresh), 1.2, 0.16); byHeight(trail([4, 5, 6], fresh, now), 1.7, 0.85); }
  if (on.reached) for (const view of reached) if (view.t <= now) wedge(view, '#0891b2', 14);
  if (on.given) for (const place of data.givenUp) if (place.t <= now) {
    const x = X(place.place[0]), y = Y(place.place[1]);
    pen.strokeStyle = '#7f1d1d'; pen.lineWidth = 2; pen.beginPath(); pen.moveTo(x - 4, y - 4); pen.lineTo(x + 4, y + 4); pen.moveTo(x + 4, y - 4); pen.lineTo(x - 4, y + 4); pen.stroke();
  }
  const under = plan && now <= plan.ready + plan.step * plan.base.length + 4;
  if (on.candidates && decision && now - decision.t < 20) {
    pen.globalAlpha = 0.5;
    decision.candidates.forEach((view, k) => { if (k !== decision.chosen) wedge(view, COLOR.candidate, 11, 2.4); });
    pen.globalAlpha = 1;
  }
  if (on.chosen && under) frustum(plan.goal, Math.min(begin.robot.range, 1.6), COLOR.chosen, 0.12);
  if (under && on.base) { stroke(plan.base, '#ffffff', 4); stroke(plan.base, '#15803d', 2.2, [7, 4]); }
  if (under && on.camera) byHeight(plan.camera, 2.4, 1);
  // Over the paths, which would hide them.
  order.forEach((p, k) => badge(p, k + 1, '#64748b'));
  if (on.tags) drawTags();
  if (pose) {
    if (on.frustum) frustum(pose.view, Math.min(begin.robot.range, 2), '#f59e0b', 0.16);
    drawRobot(pose.base, pose.arm);
  }
  const horizon = latest(horizons, now);
  if (on.horizon && horizon && now - horizon.t < 1) { stroke(horizon.base, '#ffffff', 5); stroke(horizon.base, COLOR.horizon, 3); }
  if (on.camera) heightBar();
}
function heightBar() {
  const w = 96, x = map.clientWidth - w - 44, y = map.clientHeight - 12;
  pen.fillStyle = 'rgba(255,255,255,.85)'; pen.fillRect(x - 34, y - 18, w + 76, 26);
  for (let k = 0; k < w; k++) { pen.fillStyle = heightColor(0.2 + (1.5 * k) / w); pen.fillRect(x + k, y - 4, 1.5, 8); }
  text('camera height', x + w / 2, y - 7, '#374151', { bold: false, align: 'center' });
  text('0.2 m', x - 2, y + 4, '#374151', { bold: false, align: 'right' }); text('1.7 m', x + w + 3, y + 4, '#374151', { bold: false });
}
function drawFlap() {
  if (on.scene) drawScene();
  if (on.volumes) for (const v of begin.volumes) {
    const x = X(v.low[0]), y = Y(v.high[1]), w = (v.high[0] - v.low[0]) * camera.scale, h = (v.high[1] - v.low[1]) * camera.scale;
    pen.fillStyle = 'rgba(239, 68, 68, .12)'; pen.fillRect(x, y, w, h); pen.strokeStyle = '#dc2626'; pen.lineWidth = 1.5; pen.strokeRect(x, y, w, h);
  }
  if (on.sampled) for (const view of sampled) { pen.globalAlpha = 0.55; wedge(view, '#94a3b8', 12); pen.globalAlpha = 1; }
  const taken = looks.filter((l) => l.t <= now + 1e-6), next = looks[taken.length];
  const way = [begin.start, ...taken.map((l) => l.base)];
  // Between looks the robot is placed, not driven: the straight line tells when, not where.
  const before = taken.length ? taken[taken.length - 1].t : 0, f = next ? clamp((now - before) / Math.max(next.t - before, 1e-9), 0, 1) : 0;
  const here = next ? [0, 1].map((a) => way[way.length - 1][a] + f * (next.base[a] - way[way.length - 1][a])) : way[way.length - 1];
  if (on.base) { stroke([...way, here], '#ffffff', 3.4); stroke([...way, here], COLOR.base, 1.6, [6, 4]); dot(begin.start, 7, '#16a34a', '#ffffff'); text('start', X(begin.start[0]) + 10, Y(begin.start[1]) + 4, '#166534'); }
  if (on.frustum && taken.length) frustum(taken[taken.length - 1].view3, begin.robot.range, '#f59e0b', 0.2);
  if (on.looks) taken.forEach((look, k) => { wedge(look.view3, '#1d4ed8', 22); badge(look.view3.p, k + 1, '#1d4ed8'); });
  const names = [];
  if (on.volumes) for (const [k, v] of begin.volumes.entries()) {
    const share = (taken.length ? taken[taken.length - 1].seen : data.volumesAtStart)[k] || 0;
    const label = `${v.name.replace(/_/g, ' ')} ${fixed(100 * share, 0)} %`;
    pen.font = 'bold ' + FONT;
    const half = pen.measureText(label).width / 2 + 3, x = X((v.low[0] + v.high[0]) / 2);
    // On a small map a name stays within it, and stands a line above another that is in its way.
    const inside = x > 0 && x < map.clientWidth && map.clientWidth > 2 * half;
    const at = { x: inside ? clamp(x, half, map.clientWidth - half) : x, y: Y(v.high[1]) - 5, half };
    while (names.some((n) => Math.abs(n.x - at.x) < n.half + half && Math.abs(n.y - at.y) < 14)) at.y -= 14;
    names.push(at);
    text(label, at.x, at.y, '#991b1b', { align: 'center' });
  }
  if (next) pen.globalAlpha = 0.35 + 0.65 * Math.abs(2 * f - 1) ** 4; // faint where it is not really
  if (taken.length < looks.length || !taken.length) drawRobot([...here, next ? Math.atan2(next.base[1] - here[1], next.base[0] - here[0]) : 0], null);
  pen.globalAlpha = 1;
}
function scaleBar() {
  const meters = [0.5, 1, 2, 5, 10, 20].find((m) => m * camera.scale > 60) || 20, w = meters * camera.scale, x = 14, y = map.clientHeight - 12;
  pen.fillStyle = 'rgba(255,255,255,.85)'; pen.fillRect(x - 6, y - 17, w + 12, 24);
  pen.strokeStyle = '#111827'; pen.lineWidth = 2; pen.beginPath(); pen.moveTo(x, y - 4); pen.lineTo(x, y); pen.lineTo(x + w, y); pen.lineTo(x + w, y - 4); pen.stroke();
  text(`${meters} m`, x + w / 2, y - 5, '#111827', { bold: false, align: 'center' });
}
function drawMap() {
  const box = prepare(map);
  if (!box) return;
  pen.fillStyle = '#eef0f3'; pen.fillRect(0, 0, box.w, box.h);
  paintCells();
  pen.imageSmoothingEnabled = false;
  const width = nx * grid.cell_size * camera.scale, height = ny * grid.cell_size * camera.scale;
  pen.drawImage(raster, X(grid.low[0]), Y(grid.low[1]) - height, width, height);
  if (flap) drawFlap(); else drawHeats();
  scaleBar();
}

// ---------------------------------------------------------------- the arm from the side and from behind
function drawArm() {
  const box = prepare($('arm')), pose = poseAt(now);
  if (!box || !pose) return;
  const { c, w, h } = box, floor = h - 18;
  // The arm at full stretch, with the field of view, stays within its panel.
  const left = 30, half = (w - left) / 4, scale = Math.min((floor - 10) / 2.0, half / 1.42);
  const panel = (middle, axis, mirrored, label) => {
    const at = (p) => [middle + (mirrored ? -1 : 1) * p[axis] * scale, floor - p[2] * scale];
    c.textAlign = 'center'; c.fillStyle = '#4b5563'; c.fillText(label, middle, h - 4);
    c.strokeStyle = '#e5e7eb'; c.lineWidth = 1;
    for (const z of [0, 0.5, 1, 1.5, 2]) {
      const y = floor - z * scale;
      c.beginPath(); c.moveTo(middle - half + 4, y); c.lineTo(middle + half - 4, y); c.stroke();
      if (axis === 0) { c.textAlign = 'right'; c.fillStyle = '#6b7280'; c.fillText(z ? `${fixed(z)}` : '0 m', middle - half, y + 4); }
    }
    const [low, high] = begin.robot.base, a = at([low[0], low[1], low[2]]), b = at([high[0], high[1], high[2]]);
    c.fillStyle = '#475569'; c.fillRect(Math.min(a[0], b[0]), b[1], Math.abs(b[0] - a[0]), a[1] - b[1]);
    const foot = pose.arm[0];
    c.strokeStyle = '#475569'; c.lineWidth = 0.16 * scale; c.beginPath(); c.moveTo(...at([foot[0], foot[1], high[2]])); c.lineTo(...at(foot)); c.stroke();
    c.lineCap = 'round'; c.lineJoin = 'round';
    for (const [color, width] of [['#92400e', 0.11 * scale], ['#f59e0b', 0.085 * scale]]) {
      c.strokeStyle = color; c.lineWidth = width; c.beginPath();
      pose.arm.forEach((p, k) => (k ? c.lineTo(...at(p)) : c.moveTo(...at(p)))); c.stroke();
    }
    for (const p of pose.arm.slice(1, -1)) { c.beginPath(); c.arc(...at(p), 0.035 * scale, 0, 7); c.fillStyle = '#ffffff'; c.fill(); }
    // The camera's field of view, turned into the frame of the base.
    const yaw = pose.base[2], lens = pose.arm[pose.arm.length - 1], [hf, vf] = begin.robot.camera;
    const rays = [[-hf, -vf], [hf, -vf], [hf, vf], [-hf, vf]].map(([x, y]) => {
      const d = rotate(pose.view.q, [0.35 * x, 0.35 * y, 0.35]);
      return at([lens[0] + Math.cos(yaw) * d[0] + Math.sin(yaw) * d[1], lens[1] - Math.sin(yaw) * d[0] + Math.cos(yaw) * d[1], lens[2] + d[2]]);
    });
    const shape = hull([at(lens), ...rays]);
    c.beginPath(); shape.forEach((p, k) => (k ? c.lineTo(...p) : c.moveTo(...p))); c.closePath();
    c.fillStyle = 'rgba(37, 99, 235, .18)'; c.fill(); c.strokeStyle = '#2563eb'; c.lineWidth = 1; c.stroke();
    c.beginPath(); c.arc(...at(lens), 0.045 * scale, 0, 7); c.fillStyle = '#1d4ed8'; c.fill();
  };
  panel(left + half, 0, false, 'from the right, front \u2192');
  panel(left + 3 * half, 1, true, 'from behind');
}

// ---------------------------------------------------------------- plots
function axes(canvas, { top, unit, ticks, right }) {
  const box = prepare(canvas);
  if (!box) return null;
  const { c, w, h } = box, frame = { left: 46, right: w - (right ? 26 : 12), top: 9, bottom: h - 20 };
  const x = (t) => frame.left + (t / end) * (frame.right - frame.left), y = (v) => frame.bottom - (v / top) * (frame.bottom - frame.top);
  c.lineWidth = 1; c.fillStyle = '#6b7280';
  for (const v of ticks) {
    c.strokeStyle = '#e5e7eb'; c.beginPath(); c.moveTo(frame.left, y(v)); c.lineTo(frame.right, y(v)); c.stroke();
    c.textAlign = 'right'; c.fillText(`${+v.toPrecision(3)}${unit}`, frame.left - 4, y(v) + 4);
  }
  const step = [1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200].find((s) => end / s <= Math.max(w / 75, 2)) || end;
  c.textAlign = 'center';
  for (let t = 0; t <= end; t += step) if (x(t) < frame.right - 12 || t === 0) c.fillText(t ? `${t}` : '0 s', x(t), h - 6);
  canvas.toTime = (px) => ((px - frame.left) / (frame.right - frame.left)) * end;
  return { c, x, y, frame };
}
function line(c, points, color, width = 1.8, dash = []) {
  c.beginPath(); points.forEach(([px, py], k) => (k ? c.lineTo(px, py) : c.moveTo(px, py)));
  c.strokeStyle = color; c.lineWidth = width; c.setLineDash(dash); c.lineJoin = 'round'; c.stroke(); c.setLineDash([]);
}
const stairs = (points) => points.flatMap((p, k) => (k ? [[p[0], points[k - 1][1]], p] : [p]));
function cursor({ c, x, frame }) {
  line(c, [[x(now), frame.top], [x(now), frame.bottom]], '#111827', 1);
}
const STAGE = { map_update_ms: '#64748b', frontier_ms: '#e11d48', viewpoints_ms: '#7c3aed', decision_ms: '#0891b2', base_path_ms: '#16a34a', arm_path_ms: '#f59e0b', mpc_ms: '#ea580c' };
const stageName = (name) => name.replace(/_ms$/, '').replace(/_/g, ' ');
function drawCoverage() {
  const count = Math.max(tags.length, 1), a = axes($('plot'), { top: 100, unit: ' %', ticks: [0, 25, 50, 75, 100], right: true });
  if (!a) return;
  const { c, x, y, frame } = a, share = (name) => progress.map((p) => [x(p.t), y(100 * p[name])]);
  line(c, share('explored'), '#2563eb'); line(c, share('inspected'), SURFACE.inspected);
  const steps = stairs([[x(0), y(0)], ...found.map((f, k) => [x(f.t), y((100 * (k + 1)) / count)]), [x(end), y((100 * found.length) / count)]]);
  line(c, steps, COLOR.found, 1.5, [4, 3]);
  c.fillStyle = '#166534'; c.textAlign = 'left'; c.fillText(`${count}`, frame.right + 4, y(100) + 4); c.fillText('0', frame.right + 4, y(0) + 4);
  cursor(a);
}
function drawStages() {
  const shown = stages.filter((s) => STAGE[s.name]), canvas = $('second'), bins = Math.max(10, Math.floor((canvas.clientWidth - 50) / 4));
  const width = end / bins, totals = shown.map(() => new Float64Array(bins));
  shown.forEach((stage, k) => stage.rows.forEach((r) => { totals[k][clamp(Math.floor(r.t / width), 0, bins - 1)] += r.total; }));
  const sums = Array.from({ length: bins }, (_, b) => totals.reduce((sum, column) => sum + column[b], 0) / width);
  const top = Math.max(...sums, 1) * 1.3, digit = 10 ** Math.floor(Math.log10(top)), step = [0.1, 0.2, 0.5, 1, 2].map((s) => s * digit).find((s) => top / s <= 5) || digit;
  const ticks = []; for (let v = 0; v <= top; v += step) ticks.push(v);
  const a = axes(canvas, { top, unit: '', ticks });
  if (!a) return;
  for (let b = 0; b < bins; b++) {
    let sum = 0;
    shown.forEach((stage, k) => {
      const value = totals[k][b] / width;
      if (!value) return;
      a.c.fillStyle = STAGE[stage.name]; a.c.fillRect(a.x(b * width), a.y(sum + value), Math.max(a.x(width) - a.x(0) - 0.4, 0.8), a.y(sum) - a.y(sum + value));
      sum += value;
    });
  }
  cursor(a);
}
function drawSuccess() {
  const a = axes($('plot'), { top: 100, unit: ' %', ticks: [0, 25, 50, 75, 100] });
  if (!a) return;
  const { c, x, y, frame } = a;
  const steps = stairs([[x(0), y(0)], ...looks.map((l) => [x(l.t), y(100 * l.probability)]), [x(end), y(100 * (looks.length ? looks[looks.length - 1].probability : 0))]]);
  line(c, steps, '#1d4ed8', 2);
  looks.forEach((l, k) => { c.beginPath(); c.arc(x(l.t), y(100 * l.probability), 3, 0, 7); c.fillStyle = '#1d4ed8'; c.fill(); c.fillStyle = '#374151'; c.textAlign = 'center'; c.fillText(k + 1, x(l.t), y(100 * l.probability) - 6); });
  const expected = data.result?.expected_time_s ?? looks[looks.length - 1]?.expected;
  if (expected) { line(c, [[x(expected), frame.top], [x(expected), frame.bottom]], '#dc2626', 1.2, [5, 4]); c.fillStyle = '#991b1b'; c.textAlign = 'left'; c.fillText(`expected ${fixed(expected)} s`, x(expected) + 5, frame.bottom - 6); }
  cursor(a);
}
const VOLUME = ['#dc2626', '#2563eb', '#16a34a', '#7c3aed', '#ea580c', '#0891b2', '#a16207', '#be185d'];
function drawVolumes() {
  const a = axes($('second'), { top: 100, unit: ' %', ticks: [0, 25, 50, 75, 100] });
  if (!a) return;
  begin.volumes.forEach((_, k) => {
    const share = (l) => a.y(100 * (l.seen[k] || 0));
    line(a.c, stairs([[a.x(0), a.y(100 * (data.volumesAtStart[k] || 0))], ...looks.map((l) => [a.x(l.t), share(l)]), ...(looks.length ? [[a.x(end), share(looks[looks.length - 1])]] : [])]), VOLUME[k % VOLUME.length], 1.6);
  });
  cursor(a);
}
function drawMarks() {
  const box = prepare($('marks'));
  if (!box) return;
  const { c, w } = box, x = (t) => 8 + (t / end) * (w - 16);
  c.fillStyle = '#e5e7eb'; c.fillRect(8, 9, w - 16, 2);
  const tick = (t, color, high) => { c.fillStyle = color; c.fillRect(x(t) - 0.75, 11 - high, 1.5, high); };
  for (const view of reached) tick(view.t, '#67a9bd', 5);
  for (const f of found) tick(f.t, COLOR.found, 11);
  for (const look of looks) tick(look.t, '#1d4ed8', 8);
  $('marks').toTime = (px) => ((px - 8) / (w - 16)) * end;
}
for (const canvas of [$('plot'), $('second'), $('marks')]) {
  const go = (e) => { if (e.buttons & 1 && canvas.toTime) { play(false); seek(canvas.toTime(e.offsetX)); } };
  canvas.addEventListener('pointerdown', go); canvas.addEventListener('pointermove', go);
}

// ---------------------------------------------------------------- words and tables
const escape = (s) => String(s).replace(/[&<>"]/g, (c) => ({ '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;' })[c]);
const facts = (rows) => `<table class="facts">${rows.map(([a, b]) => `<tr><td>${escape(a)}</td><td>${escape(b)}</td></tr>`).join('')}</table>`;
const percent = (v) => `${fixed(100 * v)} %`;
function words() {
  const r = data.result, how = data.ended || 'not ended: the recording stops here';
  $('title').textContent = `${begin.system === 'heats' ? 'HEATS' : 'FLAP'}: ${begin.scene}`;
  document.title = `${begin.scene} · ${begin.planner} · seed ${begin.seed}`;
  $('summary').textContent = flap
    ? `${begin.planner} planner, seed ${begin.seed}: ${looks.length} looks, ${looks.length ? percent(looks[looks.length - 1].probability) : '0 %'} in ${fixed(end)} s; ${how}`
    : `${begin.planner} planner, ${begin.sensors === 'both' ? 'LiDAR and camera' : 'camera alone'}, seed ${begin.seed}: ${found.length} of ${tags.length} tags; ${how} at ${fixed(end)} s`;
  $('arm-box').hidden = flap || !poses.rows;
  const named = (list) => list.map(([name, color]) => `<b style="color:${color}">${escape(name)}</b>`).join(', ');
  if (flap) $('plot-title').textContent = 'Probability to have seen the object';
  else $('plot-title').innerHTML = `Share ${named([['explored', '#2563eb'], ['inspected', SURFACE.inspected]])} and ${named([['tags found', COLOR.found]])} over time`;
  if (flap) $('second-title').innerHTML = `Share known of ${named(begin.volumes.map((v, k) => [v.name.replace(/_/g, ' '), VOLUME[k % VOLUME.length]]))}`;
  else $('second-title').innerHTML = `Wall time of a simulated second, ms: ${named(stages.filter((s) => STAGE[s.name]).map((s) => [stageName(s.name), STAGE[s.name]]))}`;
  const below = $('below'), add = (html, tag = 'div') => { const box = document.createElement(tag); box.innerHTML = html; below.append(box); return box; };
  if (flap) {
    const rows = looks.map((l, k) => `<tr data-time="${l.t}"><td>${k + 1}</td><td>${fixed(l.t)}</td><td>${percent(l.probability)}</td><td>${fixed(100 * (l.probability - l.before))}</td><td>${l.cells}</td><td>${l.planned}</td><td>${fixed(l.plannedTime)}</td></tr>`).join('');
    add(`<h2>Looks</h2><table><tr><th>look</th><th>time, s</th><th>success</th><th>gain, %</th><th>new cells</th><th>views planned</th><th>expected by plan, s</th></tr>${rows}</table>`);
    add(`<h2>Volumes</h2><table><tr><th>volume</th><th>prior</th><th>known at first</th><th>at the end</th></tr>${begin.volumes.map((v, k) => `<tr><td><b style="color:${VOLUME[k % VOLUME.length]}">&#9632;</b> ${escape(v.name.replace(/_/g, ' '))}</td><td>${percent(v.probability)}</td><td>${percent(data.volumesAtStart[k] || 0)}</td><td>${looks.length ? percent(looks[looks.length - 1].seen[k] || 0) : ''}</td></tr>`).join('')}</table>`);
    if (r) add(`<h2>Result</h2>${facts([['ended', `${r.ended}: ${r.reason}`], ['mode, map', `${r.mode}, ${r.map}`], ['expected time', `${fixed(r.expected_time_s)} s`], ['execution time', `${fixed(r.execution_time_s)} s`], ['looks', r.sensing_actions], ['success', percent(r.probability)], ['first plan', `${r.first_plan_views} views, ${fixed(r.first_plan_time_s)} s expected`], ['plan, median', `${fixed(r.wall.plan_ms.median, 2)} ms CPU`], ['sampling views', `${fixed(r.wall.views_ms, 0)} ms CPU`], ['travel table', `${fixed(r.wall.table_ms, 0)} ms CPU`]])}`);
  } else {
    if (r) add(`<h2>Result</h2>${facts([['ended', `${String(r.ended).replace('_', ' ')} at ${fixed(r.search_time_s)} s`], ['tags', `${r.found} of ${r.targets}`], ['last tag', r.found ? `${fixed(r.last_target_time_s)} s` : 'none'], ['explored, inspected, seen once', `${percent(r.explored_fraction)}, ${percent(r.inspected_fraction)}, ${percent(r.seen_fraction)}`], ['base path', `${fixed(r.base_path_m)} m`], ['joint rotation', `${fixed(r.joint_rotation_rad)} rad`], ['collisions', r.collisions], ['least clearance', `${fixed(r.min_clearance_m, 3)} m`], ['decisions, views reached', `${r.decisions}, ${r.views_reached}`], ['braking commands', r.brakes], ['wall time', `${fixed(r.wall.total_s)} s, ${fixed(r.wall.real_time_factor)} times real time`]])}`);
    const rows = tags.map((t) => [t, foundAt.get(t.id)]).sort((a, b) => (a[1] ?? 1e9) - (b[1] ?? 1e9) || a[0].id - b[0].id);
    add(`<h2>Tags</h2><table><tr><th>tag</th><th>place, m</th><th>found</th></tr>${rows.map(([t, at]) => `<tr${at === undefined ? '' : ` data-time="${at}"`}><td>${t.id}</td><td>${t.center.map((v) => fixed(v, 2)).join(', ')}</td><td>${at === undefined ? 'not found' : `${fixed(at)} s`}</td></tr>`).join('')}</table>`);
    if (r) add(`<h2>Wall time of each stage</h2><table><tr><th>stage, ms</th><th>median</th><th>p95</th><th>max</th><th>calls</th></tr>${Object.entries(r.wall).filter(([, s]) => s && s.count !== undefined).map(([name, s]) => `<tr><td>${escape(stageName(name))}</td><td>${fixed(s.median, 2)}</td><td>${fixed(s.p95, 2)}</td><td>${fixed(s.max, 2)}</td><td>${s.count}</td></tr>`).join('')}</table>`);
    if (data.givenUp.length) add(`<summary>Places given up: ${data.givenUp.length}</summary><table><tr><th>time, s</th><th>place, m</th><th>voxels</th><th>why</th></tr>${data.givenUp.map((g) => `<tr data-time="${g.t}"><td>${fixed(g.t)}</td><td>${g.place.map((v) => fixed(v, 2)).join(', ')}</td><td>${g.voxels}</td><td>${escape(g.reason)}</td></tr>`).join('')}</table>`, 'details');
  }
  add(`<summary>Settings, seed and version</summary>${facts([['system, planner', `${begin.system}, ${begin.planner}`], ['scene', begin.scene], ['seed', begin.seed], ['version', `seekplan ${begin.version}`]])}<pre>${escape(begin.settings)}</pre>`, 'details');
  add(`<h2>Keys</h2><p><kbd>space</kbd> play; <kbd>&larr;</kbd> <kbd>&rarr;</kbd> one second, with <kbd>shift</kbd> ten; <kbd>n</kbd> <kbd>p</kbd> next and previous ${flap ? 'look' : 'decision'}; <kbd>Home</kbd> <kbd>End</kbd>; <kbd>1</kbd> to <kbd>9</kbd> layers; <kbd>+</kbd> <kbd>&minus;</kbd> <kbd>f</kbd> zoom and fit.</p>`);
  for (const row of document.querySelectorAll('tr[data-time]')) row.addEventListener('click', () => { play(false); seek(Number(row.dataset.time)); });
}
/** Lines break between parts only. */
function say(parts) {
  $('readout').replaceChildren(...parts.flatMap((part, k) => {
    const span = document.createElement('span');
    span.textContent = part;
    return k ? [' · ', span] : [span];
  }));
}
function readout() {
  if (flap) {
    const taken = looks.filter((l) => l.t <= now + 1e-6), l = taken[taken.length - 1];
    say([`look ${taken.length} of ${looks.length}`, `success ${percent(l ? l.probability : 0)}`, ...(l ? [`plan of ${l.planned} ${l.planned === 1 ? 'view' : 'views'}`] : [])]);
  } else {
    const p = latest(progress, now);
    say(p ? [p.activity, `explored ${percent(p.explored)}`, `inspected ${percent(p.inspected)}`, `tags ${found.filter((f) => f.t <= now + 1e-6).length} of ${tags.length}`] : []);
  }
  $('clock').textContent = `${fixed(now)} of ${fixed(end)} s`;
  slider.setAttribute('aria-valuetext', `${fixed(now)} seconds`);
}
function draw() {
  drawMap(); drawMarks();
  if (flap) { drawSuccess(); drawVolumes(); } else { drawArm(); drawCoverage(); drawStages(); }
}
let due = false;
function redraw() {
  if (due) return;
  due = true;
  requestAnimationFrame(() => {
    due = false;
    readout(); draw();
    document.body.dataset.time = fixed(now, 2);
  });
}
words();
// `#t=12.5` opens at a moment.
const wanted = /[#&]t=([\d.]+)/.exec(location.hash);
// At once: by the next frame the browser would have shown the old picture stretched to the new size.
const sizes = new ResizeObserver(() => { if (camera.fitted) fit(); draw(); });
for (const canvas of [map, $('arm'), $('plot'), $('second'), $('marks')]) sizes.observe(canvas);
seek(wanted ? Number(wanted[1]) : end);
fit();
})();
