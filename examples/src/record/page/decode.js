'use strict';
// Reads what the recorder packed: zig-zag integers of seven bits a byte, as base64.
class Reader {
  constructor(text) { this.bytes = atob(text || ''); this.at = 0; }
  get more() { return this.at < this.bytes.length; }
  int() {
    let value = 0, place = 1;
    for (;;) {
      const byte = this.bytes.charCodeAt(this.at++);
      value += (byte & 127) * place;
      if (!(byte >= 128)) break;
      place *= 128;
    }
    return value % 2 ? -(value + 1) / 2 : value / 2;
  }
  list(stride) {
    const out = new Array(this.int());
    for (let i = 0; i < out.length; i++) out[i] = this.int() + (i >= stride ? out[i - stride] : 0);
    return out;
  }
  runs() {
    const count = this.int(), out = new Int32Array(3 * count);
    for (let k = 0, end = 0; k < out.length; k += 3) {
      out[k] = end + this.int(); out[k + 1] = this.int(); out[k + 2] = this.int();
      end = out[k] + out[k + 1];
    }
    return out;
  }
  // All events, each with its time in seconds and what `read` makes of it.
  events(read) {
    const out = [];
    for (let time = 0; this.more;) { time += this.int(); out.push({ t: time / 1000, ...read(this, time / 1000) }); }
    return out;
  }
}

// Columns of a table, as arrays.
function table(text) {
  if (!text) return { rows: 0, columns: [] };
  const reader = new Reader(text), rows = reader.int(), columns = [];
  for (let c = reader.int(); c > 0; c--) {
    const column = new Float64Array(rows);
    for (let r = 0, value = 0; r < rows; r++) column[r] = value += reader.int();
    columns.push(column);
  }
  return { rows, columns };
}

// Number of values that are not above `limit`, in a rising list.
function until(list, limit, value = (x) => x) {
  let low = 0, high = list.length;
  while (low < high) { const middle = (low + high) >> 1; if (value(list[middle]) <= limit) low = middle + 1; else high = middle; }
  return low;
}

// The last event that is not after `time`.
const latest = (events, time) => events[until(events, time + 1e-6, (e) => e.t) - 1];

// A field of cells that events change; goes to any time, back by way of copies kept on the way.
class Field {
  constructor(events, size) {
    this.events = events;
    this.cells = new Uint16Array(size);
    this.done = 0;
    this.every = Math.max(16, Math.ceil(events.length / 24));
    this.copies = [this.cells.slice()];
  }
  at(time) {
    const wanted = until(this.events, time + 1e-6, (e) => e.t);
    if (wanted < this.done) {
      const copy = Math.min(Math.floor(wanted / this.every), this.copies.length - 1);
      this.cells.set(this.copies[copy]);
      this.done = copy * this.every;
    }
    while (this.done < wanted) {
      const runs = this.events[this.done++].runs;
      for (let k = 0; k < runs.length; k += 3) this.cells.fill(runs[k + 2], runs[k], runs[k] + runs[k + 1]);
      if (this.done % this.every === 0 && this.copies.length === this.done / this.every) this.copies.push(this.cells.slice());
    }
    return this.cells;
  }
}

// A camera: position in m and orientation, from seven integers.
const viewOf = (v, k = 0) => {
  const q = [v[k + 3], v[k + 4], v[k + 5], v[k + 6]], n = Math.hypot(...q) || 1;
  return { p: [v[k] / 100, v[k + 1] / 100, v[k + 2] / 100], q: q.map((x) => x / n) };
};
function rotate([x, y, z, w], v) {
  const t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])];
  return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2], v[2] + w * t[2] + x * t[1] - y * t[0]];
}
