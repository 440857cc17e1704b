// Images, decoded when they are first looked at. Values come from the files' own bytes, not through a canvas, which browsers
// may disturb so that it cannot be used to recognise them.

function blank(w, h) {
  return element('canvas', {width: w, height: h});
}

async function picture(base64) {
  const image = new Image();
  image.src = 'data:image/png;base64,' + base64;
  await image.decode();
  return image;
}

// Undoes the filter of one row of a PNG [W3C PNG, 9.2] of one byte a pixel.
function unfilter(type, row, above) {
  for (let x = 0; x < row.length; ++x) {
    const left = x ? row[x - 1] : 0, up = above ? above[x] : 0, corner = x && above ? above[x - 1] : 0;
    if (type === 1) row[x] += left;
    else if (type === 2) row[x] += up;
    else if (type === 3) row[x] += left + up >> 1;
    else if (type === 4) {
      const a = Math.abs(up - corner), b = Math.abs(left - corner), c = Math.abs(left + up - 2 * corner);
      row[x] += a <= b && a <= c ? left : b <= c ? up : corner;
    }
  }
}

// The bytes of a PNG of one 8-bit grey channel, the top row first.
async function gray_bytes(base64) {
  const file = Uint8Array.from(atob(base64), letter => letter.charCodeAt(0)), view = new DataView(file.buffer);
  const width = view.getUint32(16), height = view.getUint32(20), packed = [];
  for (let at = 8; at < file.length; at += 12 + view.getUint32(at))
    if (view.getUint32(at + 4) === 0x49444154) packed.push(file.subarray(at + 8, at + 8 + view.getUint32(at))); // 'IDAT'
  const stream = new Blob(packed).stream().pipeThrough(new DecompressionStream('deflate'));
  const filtered = new Uint8Array(await new Response(stream).arrayBuffer()), out = new Uint8Array(width * height);
  for (let y = 0; y < height; ++y) {
    const at = y * (width + 1), row = out.subarray(y * width, (y + 1) * width);
    row.set(filtered.subarray(at + 1, at + 1 + width));
    unfilter(filtered[at], row, y ? out.subarray((y - 1) * width, y * width) : null);
  }
  return out;
}

function remembered(make) {
  const known = new Map();
  return key => {
    if (!known.has(key)) known.set(key, make(key));
    return known.get(key);
  };
}

// Values from the two planes that their codes are stored in; the codes above the levels are those that are not finite.
async function decoded(png, levels, [low, high]) {
  const planes = await gray_bytes(png), count = planes.length / 2, values = new Float32Array(count), special = [-Infinity, Infinity, NaN];
  for (let i = 0; i < count; ++i) {
    const code = planes[i] << 8 | planes[i + count];
    values[i] = code > levels ? special[code - levels - 1] : low + code / levels * (high - low);
  }
  return values;
}
const values_of = remembered(entry => decoded(entry.visibility, entry.levels, entry.range));
const flip_of = remembered(async entry => entry.flip ? decoded(entry.flip, entry.flip_levels, [0, 1]) : new Float32Array(entry.view.width * entry.view.height));

const mask_of = remembered(async view => view.mask ? gray_bytes(view.mask) : null);
const in_mask = (mask, i) => !mask || mask[i] > 0;
const compared = entry => Promise.all([values_of(entry), values_of(entry.view.reference), mask_of(entry.view)]);

// The largest error of an entry among the receivers that count.
const largest_error = remembered(async entry => {
  const [values, truth, mask] = await compared(entry);
  let largest = 0;
  for (let i = 0; i < values.length; ++i) {
    const error = Math.abs(values[i] - truth[i]);
    if (error > largest && error < Infinity && in_mask(mask, i)) largest = error;
  }
  return largest;
});

function nice_range(largest) {
  if (!(largest > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(largest));
  return [1, 2, 2.5, 5, 10].map(step => +(step * power).toPrecision(3)).find(range => range >= largest * (1 - 1e-6));
}

// The colours of a layer's map as 32-bit pixels, interpolated between its anchors: so many that a value has the colour that
// the program gives it, but for rounding.
const color_table = remembered(layer => {
  const anchors = report.color_maps[layer], table = new Uint32Array(1 << 14);
  for (let i = 0; i < table.length; ++i) {
    const position = i / (table.length - 1) * (anchors.length - 1), first = Math.min(Math.floor(position), anchors.length - 2);
    const mix = shift => {
      const a = anchors[first] >> shift & 255, b = anchors[first + 1] >> shift & 255;
      return Math.round(a + (b - a) * (position - first));
    };
    table[i] = pixel(mix(16), mix(8), mix(0));
  }
  return table;
});

function pixel(red, green, blue) { return (0xff000000 | blue << 16 | green << 8 | red) >>> 0; }
const outside_color = pixel(140, 140, 140), missing_color = pixel(0, 179, 77);
const byte_of = value => Math.round(Math.min(Math.max(value, 0), 1) * 255);

// A canvas of the entry's size with the colour that `color(i)` says.
function painted({width, height}, color) {
  const canvas = blank(width, height), context = canvas.getContext('2d'), image = context.createImageData(width, height);
  const out = new Uint32Array(image.data.buffer);
  for (let i = 0; i < out.length; ++i) out[i] = color(i);
  context.putImageData(image, 0, 0);
  return canvas;
}

function color_at(layer, position) {
  const table = color_table(layer);
  return table[Math.round(Math.min(Math.max(position, 0), 1) * (table.length - 1))];
}

// A layer with a colour map. FLIP was measured by the program; the others are differences.
async function map_canvas(entry, layer, range) {
  const [values, truth, mask] = await compared(entry), flip = layer === 'flip' ? await flip_of(entry) : null;
  return painted(entry.view, i => {
    if (!in_mask(mask, i)) return outside_color;
    const error = flip ? flip[i] : (values[i] - truth[i]) / range;
    if (!Number.isFinite(error)) return missing_color;
    return color_at(layer, layer === 'signed' ? 0.5 + 0.5 * error : Math.abs(error));
  });
}

// The reference, faded, and over it what the metrics `leak` (red) and `false_shadow` (blue) count.
async function leak_canvas(entry) {
  const [values, truth, mask] = await compared(entry), {umbra_up_to, lit_from, leak_above, false_shadow_below} = report.thresholds;
  return painted(entry.view, i => {
    if (!in_mask(mask, i)) return outside_color;
    if (!Number.isFinite(values[i]) || !Number.isFinite(truth[i])) return missing_color;
    if (truth[i] <= umbra_up_to && values[i] > leak_above) return pixel(255, 255 - byte_of(0.5 + values[i] / 2), 40);
    if (truth[i] >= lit_from && values[i] < false_shadow_below) return pixel(byte_of(values[i] / 2), 96, 255);
    const gray = byte_of(0.25 + 0.6 * truth[i]);
    return pixel(gray, gray, gray);
  });
}

async function visibility_canvas(entry) {
  const values = await values_of(entry);
  return painted(entry.view, i => {
    const gray = byte_of(values[i]);
    return Number.isFinite(values[i]) ? pixel(gray, gray, gray) : missing_color;
  });
}

// What a layer of an entry looks like, for drawing: an image or a canvas. The latest dozen are kept.
const drawn = new Map();
function layer_image(entry, layer, range) {
  const key = [entries.indexOf(entry), layer, is_error_layer(layer) ? range : ''].join();
  let image = drawn.get(key);
  drawn.delete(key);
  image ??= layer === 'shaded' ? picture(entry.shaded) : layer === 'visibility' ? visibility_canvas(entry)
    : layer === 'leaks' ? leak_canvas(entry) : map_canvas(entry, layer, range);
  drawn.set(key, image);
  if (drawn.size > 12) drawn.delete(drawn.keys().next().value);
  return image;
}

// A colour bar as a strip one pixel high.
const color_bar = layer => painted({width: 1024, height: 1}, i => color_at(layer, i / 1023));
const range_ends = (layer, range) => layer === 'signed' ? ['−' + range, '0', '+' + range] : ['0', String(+(range / 2).toPrecision(6)), String(range)];
